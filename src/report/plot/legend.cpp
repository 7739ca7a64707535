#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "report/plot/layout.hpp"
#include "text/printable_text.hpp"

namespace viscobar::plot {

using namespace layout;

namespace {

constexpr std::array<std::string_view, 6> dashes = {"", "7 4", "2 3", "9 3 2 3", "4 2", "12 4"};

// The text in lines of at most so many letters, broken behind spaces, dashes and the like, where there are some.
std::vector<std::string> wrapped(std::string_view text, std::size_t most) {
  std::vector<std::string> lines(1);
  std::size_t good = 0;  // bytes of the last line up to where it may be broken
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string& line = lines.back();
    const bool begins = (text[i] & 0xc0) != 0x80;
    if (begins && letters(line) == most) {
      std::string rest = line.substr(good > 0 ? good : line.size());
      line.resize(line.size() - rest.size());
      lines.push_back(std::move(rest));
      good = 0;
    }
    lines.back() += text[i];
    if (std::string_view(" ,-/_").find(text[i]) != std::string_view::npos) good = lines.back().size();
  }
  return lines;
}

}  // namespace

std::span<const std::string_view> dash_shapes() { return dashes; }

std::string stroke_css(const Style& style, double thickness) {
  const std::string_view dash = style.dashed ? "6 4" : dashes[style.shape % dashes.size()];
  return fmt::format("stroke:{};stroke-width:{}{}{}", style.colour, thickness,
                     dash.empty() ? "" : ";stroke-dasharray:", dash);
}

void Figure::colour_bar(const ColourMap& map, const Axis& values, std::string_view symbol) {
  const double bar = right + 20, bottom = height_ - below - 44, length = bottom - top;
  std::vector<ColourStop> stops;
  for (std::size_t i = 0; i < map.anchors.size(); ++i)
    stops.push_back({static_cast<double>(i) / static_cast<double>(map.anchors.size() - 1), map.anchors[i]});
  const std::string_view unit =
      std::string_view(values.label).substr(std::min(values.label.rfind('['), values.label.size()));
  const std::string fill = gradient(stops, R"( x1="0" y1="1" x2="0" y2="0")");
  legend_ += fmt::format(
      "<g class=\"scale\" data-name=\"{}\" data-low=\"{:.9g}\" data-high=\"{:.9g}\" data-unit=\"{}\">"
      "<rect class=\"frame\" style=\"fill:{}\" x=\"{}\" y=\"{}\" width=\"16\" height=\"{}\"/></g>\n",
      symbol, values.low, values.high, unit.ends_with(']') ? escaped(unit.substr(1, unit.size() - 2)) : "", fill, bar,
      top, length);
  const Ticks marks = ticks(values, 6);
  for (const Tick& tick : marks.ticks) {
    const double y = bottom - values.position(tick.value) * length;
    legend_ +=
        fmt::format("<path class=\"frame\" d=\"M{} {:.1f}h4\"/><text x=\"{}\" y=\"{:.1f}\" dy=\".35em\">{}</text>",
                    bar + 16, y, bar + 24, y, tick.label);
  }
  legend_ +=
      fmt::format("<text class=\"axis\" transform=\"rotate(-90)\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                  -(top + bottom) / 2, bar + 78, escaped(values.label) + factor(marks));
  legend_y_ = bottom + 22;
}

void Figure::words_beside(double y, std::string_view words) {
  legend_ +=
      fmt::format("<text x=\"{}\" y=\"{:.1f}\" dy=\".35em\">{}</text>\n", right + 14, place_y(y), escaped(words));
}

void Figure::legend_box(const std::string& colour, std::string_view text) {
  legend_key(fmt::format("<path style=\"fill:{}\" d=\"M0 -5h20v10h-20z\"/>", colour), text, "");
}

void Figure::legend_note(std::string_view text) { legend_key("", text, "", 0.0); }

void Figure::legend_line(const Style& style, std::string_view text) {
  if (text.empty()) return;
  legend_key(fmt::format("<path class=\"line\" style=\"{}\" d=\"M0 0h20\"/>",
                         stroke_css(style, std::clamp(style.width, 1.6, 7.0))),
             text, fmt::format(" data-key=\"{}\"", escaped(text)));
}

void Figure::legend_key(std::string_view mark, std::string_view text, std::string_view key, double indent,
                        bool one_line) {
  constexpr double font = 13.0, from = right + 14.0;
  const double most = (width - from - indent) / (font * of_letter);
  const auto size = static_cast<double>(letters(text));
  std::string words;
  double height = legend_pitch;
  if (one_line || size <= most) {
    words = escaped(text);
  } else {
    const std::vector<std::string> lines = wrapped(text, static_cast<std::size_t>(most));
    for (std::size_t i = 0; i < lines.size(); ++i)
      words += fmt::format("<tspan x=\"{}\" dy=\"{}\">{}</tspan>", indent, i == 0 ? ".35em" : "15", escaped(lines[i]));
    height += line_pitch * static_cast<double>(lines.size() - 1);
  }
  const std::string smaller =
      one_line && size > most ? fmt::format(" style=\"font-size:{:.1f}px\"", std::max(7.0, font * most / size)) : "";
  legend_ +=
      fmt::format("<g class=\"key\" transform=\"translate({} {})\"{}>{}<text x=\"{}\" dy=\".35em\"{}>{}</text></g>\n",
                  from, legend_y_, key, mark, indent, smaller, words);
  legend_y_ += height;
}

void Figure::begin_still() {
  content_ += "<g class=\"still\">\n";
  legend_ += "<g class=\"still\">\n";
}
void Figure::end_still() {
  content_ += "</g>\n";
  legend_ += "</g>\n";
}

}  // namespace viscobar::plot
