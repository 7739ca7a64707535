#include "report/plot/colours.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace viscobar::plot {

namespace {

constexpr std::array<Colour, 17> sequential_anchors = {0x240246, 0x270d5f, 0x221d78, 0x09308e, 0x004984, 0x045a84,
                                                       0x026a89, 0x047a8f, 0x088b93, 0x0d9c96, 0x02ad95, 0x12bf8e,
                                                       0x4bce80, 0x87d77c, 0xb3df81, 0xd7e78f, 0xf4efa6};
constexpr std::array<Colour, 17> diverging_anchors = {0x1f4694, 0x2f5ca9, 0x4071be, 0x5a88c9, 0x769ed3, 0x92b3dd,
                                                      0xb1c9e6, 0xd1deee, 0xf3f3f3, 0xecd8ce, 0xe2beac, 0xd7a38b,
                                                      0xcb896c, 0xbe6f4d, 0xb0542c, 0x9a3e15, 0x822b02};

struct Variable {
  std::string_view name, light, dark;
};

// The sequence is mixed in the OKLCH space: #e3a72f to #31135e, on a dark page #7d4fc4 to #ffe08a.
constexpr std::array variables = {
    Variable{"series-0", "#0072b2", "#5ab4ec"},    Variable{"series-1", "#c8500a", "#ff9a52"},
    Variable{"series-2", "#00855f", "#3ccb9c"},    Variable{"series-3", "#a8538a", "#e29acb"},
    Variable{"series-4", "#7d6b00", "#d9c64a"},    Variable{"series-5", "#56616c", "#a9b4bf"},
    Variable{"series-6", "#5a43c4", "#b3a4ff"},    Variable{"series-7", "#a3121f", "#ff8d8d"},
    Variable{"series-8", "#6b3e1f", "#d2a679"},    Variable{"series-9", "#0a7d8c", "#62d3e0"},
    Variable{"sequence-0", "#e3a72f", "#7d4fc4"},  Variable{"sequence-1", "#e1932f", "#9753bf"},
    Variable{"sequence-2", "#db8037", "#ae58b7"},  Variable{"sequence-3", "#d26e41", "#c35fad"},
    Variable{"sequence-4", "#c65e4b", "#d667a2"},  Variable{"sequence-5", "#b84f54", "#e57196"},
    Variable{"sequence-6", "#a8435c", "#f27d8a"},  Variable{"sequence-7", "#963862", "#fb8b80"},
    Variable{"sequence-8", "#822f65", "#ff9b78"},  Variable{"sequence-9", "#6e2867", "#ffac74"},
    Variable{"sequence-10", "#592167", "#ffbd75"}, Variable{"sequence-11", "#451a64", "#ffcf7d"},
    Variable{"sequence-12", "#31135e", "#ffe08a"}, Variable{"ink", "#1d2126", "#e4e7ea"},
    Variable{"soft", "#5b646e", "#9aa4ae"},        Variable{"rule", "#c9ced4", "#4a525b"},
    Variable{"faint", "#e8ebee", "#2a3037"},       Variable{"paper", "#ffffff", "#1a1e23"},
    Variable{"page", "#f5f6f8", "#121519"},
};
constexpr double last_of_sequence = 12.0;
constexpr std::size_t colours_of_series = 10;

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

std::string series_colour(std::size_t index) { return fmt::format("var(--series-{})", index % colours_of_series); }

std::string sequence_colour(double position) {
  return fmt::format("var(--sequence-{:.0f})", std::round(last_of_sequence * std::clamp(position, 0.0, 1.0)));
}

std::string palette_css() {
  std::string light, dark;
  for (const Variable& variable : variables) {
    light += fmt::format("--{}:{};", variable.name, variable.light);
    dark += fmt::format("--{}:{};", variable.name, variable.dark);
  }
  return fmt::format(
      ":root{{color-scheme:light;{0}}}\n"
      "@media screen and (prefers-color-scheme:dark){{:root:not([data-theme=light]){{color-scheme:dark;{1}}}}}\n"
      "@media screen{{:root[data-theme=dark]{{color-scheme:dark;{1}}}}}\n",
      light, dark);
}

std::string in_light_colours(std::string_view text) {
  constexpr std::string_view opening = "var(--";
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t use = text.find(opening, at);
    out += text.substr(at, use - at);
    if (use == text.npos) break;
    const std::size_t name = use + opening.size(), close = text.find(')', name);
    const auto known = std::ranges::find(variables, text.substr(name, close - name), &Variable::name);
    out += known == variables.end() ? "currentColor" : known->light;
    at = close + 1;
  }
  return out;
}

}  // namespace viscobar::plot
