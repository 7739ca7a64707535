#pragma once

#include <string>
#include <vector>

namespace viscobar {

/// A picture as a file of its own, for a paper: `name`.svg.
struct FigureFile {
  std::string name;  ///< without ending
  std::string svg;   ///< the whole file
};

/// A page that needs no other file, and each of its pictures.
struct PicturedPage {
  std::string html;                 ///< the whole file
  std::vector<FigureFile> figures;  ///< in the order of the page
};

}  // namespace viscobar
