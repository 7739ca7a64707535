#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace viscobar::plot {

using Colour = std::uint32_t;  ///< 0xrrggbb

/// A colour scale: anchors at equal distances, linear in between. Both scales have lightness linear and hue monotone in
/// the OKLab space, so equal steps of the value look equal, also to colour-blind eyes.
struct ColourMap {
  std::span<const Colour> anchors;

  /// Colour at a position in [0, 1].
  Colour at(double position) const;
};

/// Dark violet to light yellow.
ColourMap sequential();
/// Blue over near white to brown, the middle standing for zero.
ColourMap diverging();

std::string hex(Colour colour);

/// CSS variable of the i-th colour of the palette (ten; the first four are told apart by colour-blind eyes).
std::string series_colour(std::size_t index);

/// CSS variable at a position in [0, 1] of a sequence from light to dark, the other way round on a dark page.
std::string sequence_colour(double position);

/// The variables themselves: light, and dark on a screen where the reader's system or the page's toggle
/// (data-theme="light" or "dark" on the root) asks for it. Print is light.
std::string palette_css();

/// CSS or SVG with every variable replaced by its light colour, for readers that know no variables.
std::string in_light_colours(std::string_view text);

}  // namespace viscobar::plot
