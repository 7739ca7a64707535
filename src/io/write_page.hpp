#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "viscobar/io/pictured_page.hpp"

namespace viscobar {

/// Writes DIR/figures/NAME.svg for each. @throws IoError
void write_figures(const std::filesystem::path& directory, const std::vector<FigureFile>& figures);

/// Writes DIR/FILE, and the figures where they are wanted. @throws IoError
void write_page(const std::filesystem::path& directory, std::string_view file, const PicturedPage& page,
                bool with_figures);

}  // namespace viscobar
