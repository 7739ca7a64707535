#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

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

/// #rrggbb
std::string hex(Colour colour);

}  // namespace viscobar::plot
