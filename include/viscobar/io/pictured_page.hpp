#pragma once

#include <string>
#include <vector>

namespace viscobar {

/// A picture as a file of its own, for a paper: `name`.svg.
struct FigureFile {
  std::string name, svg;
};

/// A page that needs no other file, and each of its pictures.
struct PicturedPage {
  std::string html;
  std::vector<FigureFile> figures;
};

}  // namespace viscobar
