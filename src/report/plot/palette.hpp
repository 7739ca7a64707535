#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace viscobar::plot {

/// CSS variable of the i-th colour of the palette (eight; the first four are told apart by colour-blind eyes).
std::string series_colour(std::size_t index);

/// CSS variable at a position in [0, 1] of a sequence from light to dark, the other way round on a dark page.
std::string sequence_colour(double position);

/// The variables themselves: light, and dark on a screen where the reader's system or the page's toggle
/// (data-theme="light" or "dark" on the root) asks for it. Print is light.
std::string palette_css();

/// CSS or SVG with every variable replaced by its light colour, for readers that know no variables.
std::string in_light_colours(std::string_view text);

}  // namespace viscobar::plot
