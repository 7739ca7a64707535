#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "report/plot/colours.hpp"

namespace viscobar::plot {

/// Base64 of RFC 4648, padded, in one line.
std::string base64(std::string_view bytes);

/// An image of palette indices (rows from the top, width * height of them) as a data: URI.
std::string png_data_uri(std::size_t width, std::size_t height, std::span<const Colour, 256> palette,
                         std::span<const std::uint8_t> pixels);

}  // namespace viscobar::plot
