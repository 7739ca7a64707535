#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

#include "report/plot/figure.hpp"
#include "text/number.hpp"

/// Measures, in pixels, that the frame of a figure and its legend share.
namespace viscobar::plot::layout {

inline constexpr double width = 960.0, least_left = 84.0, right = 800.0, top = 12.0, below = 46.0, legend_pitch = 19.0,
                        line_pitch = 15.0, strip_thickness = 18.0;

/// Widths of texts, in parts of their font's size: letters of a text, and digits of a tick.
inline constexpr double of_letter = 0.53, of_digit = 0.57;

inline std::size_t letters(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xc0) != 0x80; }));
}

}  // namespace viscobar::plot::layout

namespace viscobar::plot {

/// The factor of the labels of an axis, behind its name.
inline std::string factor(const Ticks& marks) { return marks.exponent ? " / " + power_of_ten(marks.exponent) : ""; }

/// The look of a line in CSS.
std::string stroke_css(const Style& style, double thickness);

}  // namespace viscobar::plot
