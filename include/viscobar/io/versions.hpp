#pragma once

#include <string>

namespace viscobar {

/// What a result was computed with.
struct Versions {
  std::string viscobar, sundials, hdf5, eigen;
  std::string platform;  ///< operating system, machine, compiler
};

Versions versions();

}  // namespace viscobar
