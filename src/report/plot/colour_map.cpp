#include "report/plot/colour_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace viscobar::plot {

namespace {

constexpr std::array<Colour, 17> sequential_anchors = {0x240246, 0x270d5f, 0x221d78, 0x09308e, 0x004984, 0x045a84,
                                                       0x026a89, 0x047a8f, 0x088b93, 0x0d9c96, 0x02ad95, 0x12bf8e,
                                                       0x4bce80, 0x87d77c, 0xb3df81, 0xd7e78f, 0xf4efa6};
constexpr std::array<Colour, 17> diverging_anchors = {0x1f4694, 0x2f5ca9, 0x4071be, 0x5a88c9, 0x769ed3, 0x92b3dd,
                                                      0xb1c9e6, 0xd1deee, 0xf3f3f3, 0xecd8ce, 0xe2beac, 0xd7a38b,
                                                      0xcb896c, 0xbe6f4d, 0xb0542c, 0x9a3e15, 0x822b02};

}  // namespace

Colour ColourMap::at(double position) const {
  const double scaled = std::clamp(position, 0.0, 1.0) * static_cast<double>(anchors.size() - 1);
  const auto index = std::min(static_cast<std::size_t>(scaled), anchors.size() - 2);
  const double weight = scaled - static_cast<double>(index);
  Colour mixed = 0;
  for (const unsigned shift : {16U, 8U, 0U}) {
    const double from = (anchors[index] >> shift) & 0xff, to = (anchors[index + 1] >> shift) & 0xff;
    mixed |= static_cast<Colour>(std::lround(from + weight * (to - from))) << shift;
  }
  return mixed;
}

ColourMap sequential() { return {sequential_anchors}; }
ColourMap diverging() { return {diverging_anchors}; }

std::string hex(Colour colour) { return fmt::format("#{:06x}", colour); }

}  // namespace viscobar::plot
