#pragma once

#include <string>

namespace viscobar {

/// Versions of the program, libraries and machine that computed a result.
struct Versions {
  std::string viscobar;  ///< this library
  std::string build;     ///< of this library or the program it is linked into: differs where their code does
  std::string sundials;  ///< linked
  std::string hdf5;      ///< linked
  std::string eigen;     ///< compiled with
  std::string platform;  ///< operating system, machine, compiler
};

/// Versions of this build.
Versions versions();

}  // namespace viscobar
