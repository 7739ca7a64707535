#include "report/plot/figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <functional>
#include <iterator>

#include "text/joined.hpp"
#include "text/json_text.hpp"
#include "text/number.hpp"
#include "text/printable_text.hpp"

namespace viscobar::plot {

namespace {

constexpr double width = 960.0, left = 84.0, right = 800.0, top = 12.0, below = 46.0, legend_pitch = 19.0;

// 1 / 10^5 of a picture, and enough digits of a time to tell its events apart.
constexpr int digits_of_y = 5, digits_of_x = 9;

std::string json(const Axis& axis) {
  std::string text =
      fmt::format(R"({{"label":{},"low":{:.9g},"high":{:.9g})", json_string(axis.label), axis.low, axis.high);
  if (axis.scale == Scale::logarithmic) text += R"(,"log":true)";
  if (axis.bare) text += R"(,"bare":true)";
  if (!axis.link.empty()) text += fmt::format(R"(,"link":{})", json_string(axis.link));
  return text + '}';
}

std::string json(std::span<const Interval> parts) {
  std::vector<double> ends;
  for (const Interval& part : parts) ends.insert(ends.end(), {part.begin, part.end});
  return json_numbers(ends, std::identity(), digits_of_x);
}

std::string json(std::span<const Point> points, const Axis& y) {
  const auto x_of = [](Point point) { return point.x; };
  const auto y_of = [](Point point) { return point.y; };
  return joined({R"("x":)", json_numbers(points, x_of, digits_of_x), R"(,"y":)",
                 json_numbers(points, y_of, y.significant_digits(digits_of_y))});
}

std::string json(const Style& style, std::string_view legend) {
  return fmt::format(R"("colour":{},"width":{}{}{},"label":{})", json_string(style.colour), style.width,
                     style.dashed ? R"(,"dashed":true)" : "",
                     style.shape > 0 ? fmt::format(R"(,"shape":{})", style.shape) : "", json_string(legend));
}

// The script has the same: src/report/web/layers.js.
constexpr std::array dashes = {"", "7 4", "2 3", "9 3 2 3", "4 2", "12 4"};

std::string dash_css(const Style& style) {
  const std::string_view dash = style.dashed ? "6 4" : dashes[style.shape % dashes.size()];
  return dash.empty() ? "" : fmt::format(";stroke-dasharray:{}", dash);
}

std::string marker_path(std::size_t shape, double x, double y, double r) {
  switch (shape % 6) {
    case 1: return fmt::format("M{:.1f} {:.1f}h{}v{}h{}z", x - r, y - r, 2 * r, 2 * r, -2 * r);
    case 2: return fmt::format("M{:.1f} {:.1f}l{} {}h{}z", x, y - 1.2 * r, 1.2 * r, 2.1 * r, -2.4 * r);
    case 3: return fmt::format("M{0:.1f} {1:.1f}l{2} {3}l-{2} {3}l-{2} -{3}z", x, y - 1.35 * r, 1.2 * r, 1.35 * r);
    case 4: return fmt::format("M{0:.1f} {1:.1f}l{2} {2}M{3:.1f} {1:.1f}l-{2} {2}", x - r, y - r, 2 * r, x + r);
    case 5: return fmt::format("M{:.1f} {:.1f}l{} {}h{}z", x, y + 1.2 * r, 1.2 * r, -2.1 * r, -2.4 * r);
    default: return fmt::format("M{0:.1f} {1:.1f}a{2} {2} 0 1 0 {3} 0a{2} {2} 0 1 0 -{3} 0z", x - r, y, r, 2 * r);
  }
}

// Factor of the labels of an axis, behind its name.
std::string factor(const Ticks& marks) { return marks.exponent ? " / " + power_of_ten(marks.exponent) : ""; }

// The gradients of all figures of a page share one name space; svg() puts the picture's title into their names.
constexpr char place_of_title = '\x01';

std::string named_after(std::string text, std::string_view title) {
  std::string name;
  for (const char c : title) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '-';
  for (std::size_t at = 0; (at = text.find(place_of_title, at)) != text.npos;) text.replace(at, 1, name);
  return text;
}

}  // namespace

double height_of_bars(std::size_t rows) { return top + below + legend_pitch * static_cast<double>(rows) + 1.0; }

Figure::Figure(Axis x, Axis y, double height)
    : x_(std::move(x)), y_(std::move(y)), height_(height), legend_y_(top + 10.0) {}

double Figure::place_x(double value) const { return left + x_.position(value) * (right - left); }
double Figure::place_y(double value) const {
  const double bottom = height_ - below;
  return bottom - y_.position(value) * (bottom - top);
}

std::string Figure::boxes(std::span<const Interval> parts, double top, double height, double least) const {
  std::string d;
  for (const Interval& part : parts) {
    const double from = place_x(std::max(part.begin, x_.low)), to = place_x(std::min(part.end, x_.high));
    if (to < from) continue;
    const double size = std::max(least, to - from);
    fmt::format_to(std::back_inserter(d), "M{:.2f} {:.2f}h{:.2f}v{}h{:.2f}z", from, top, size, height, -size);
  }
  return d;
}

void Figure::shade(std::span<const Interval> bands, const std::string& colour, std::string_view legend) {
  const std::string d = boxes(bands, top, height_ - below - top, 1.0);
  if (d.empty()) return;
  live_layer(fmt::format(R"({{"kind":"bands","colour":{},"label":{},"parts":{}}})", json_string(colour),
                         json_string(legend), json(bands)));
  content_ += fmt::format("<path class=\"band\" style=\"fill:{}\" d=\"{}\"/>\n", colour, d);
  if (!legend.empty()) legend_box(colour, legend, "band");
}

void Figure::level(double y, const Style& style, std::string_view legend) {
  live_layer(fmt::format(R"({{"kind":"level","y":{:.9g},{}}})", y, json(style, legend)));
  stroke(std::vector<Point>{{x_.low, y}, {x_.high, y}}, style);
  legend_line(style, legend);
}

void Figure::body(double y, Interval part, bool above) {
  const double from = place_x(part.begin), to = place_x(part.end), surface = place_y(y);
  const double depth = std::clamp(above ? surface : height_ - below - surface, 0.0, 12.0);
  live_layer(fmt::format(R"({{"kind":"body","y":{:.9g},"from":{:.9g},"to":{:.9g}{}}})", y, part.begin, part.end,
                         above ? R"(,"above":true)" : ""));
  content_ += fmt::format(
      "<rect class=\"body\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"/>"
      "<path class=\"surface\" d=\"M{:.2f} {:.2f}H{:.2f}\"/>\n",
      from, above ? surface - depth : surface, to - from, depth, from, surface, to);
}

void Figure::stroke(std::span<const Point> points, const Style& style) {
  std::string d;
  for (const Point& point : points) {
    const double x = place_x(point.x), y = place_y(point.y);
    if (!std::isfinite(x) || !std::isfinite(y)) continue;
    d += d.empty() ? 'M' : 'L';
    append_decimals(d, x, 1);
    d += ' ';
    append_decimals(d, y, 1);
  }
  content_ += fmt::format("<path class=\"line\" style=\"stroke:{};stroke-width:{}{}\" d=\"{}\"/>\n", style.colour,
                          style.width, dash_css(style), d);
}

void Figure::line(std::span<const Point> points, const Style& style, std::string_view legend) {
  live_layer(joined({R"({"kind":"line",)", json(style, legend), ",", json(points, y_), "}"}));
  constexpr std::size_t told_apart = 600;
  if (points.size() > 4 * told_apart)
    stroke(thin(points, told_apart), style);
  else
    stroke(points, style);
  legend_line(style, legend);
}

void Figure::markers(std::span<const Point> points, const std::string& colour, std::string_view legend,
                     std::size_t shape) {
  constexpr double radius = 3.5;
  live_layer(fmt::format(R"({{"kind":"marks","colour":{},"label":{},"shape":{},{}}})", json_string(colour),
                         json_string(legend), shape, json(points, y_)));
  const auto marker = [&](double x, double y) {
    return fmt::format("<path class=\"marker\" style=\"fill:{0};stroke:{0}\" d=\"{1}\"/>", colour,
                       marker_path(shape, x, y, radius));
  };
  for (const Point& point : points) content_ += marker(place_x(point.x), place_y(point.y)) + '\n';
  if (legend.empty()) return;
  legend_ += marker(right + 24, legend_y_);
  legend_text(legend);
}

void Figure::series(std::span<const Point> points, const Style& style, std::string_view legend) {
  line(points, style, legend);
  markers(points, style.colour, {}, style.shape);
}

void Figure::label(Point at, std::string_view text) {
  live_layer(fmt::format(R"({{"kind":"text","x":{:.9g},"y":{:.9g},"text":{}}})", at.x, at.y, json_string(text)));
  content_ += fmt::format("<text class=\"note\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", place_x(at.x) + 6,
                          place_y(at.y) - 6, escaped(text));
}

void Figure::marker_line(double x, const Style& style, std::string_view text) {
  live_layer(fmt::format(R"({{"kind":"upright","x":{:.9g},{},"text":{}}})", x, json(style, {}), json_string(text)));
  stroke(std::vector<Point>{{x, y_.low}, {x, y_.high}}, style);
  content_ +=
      fmt::format("<text class=\"note\" x=\"{:.1f}\" y=\"{}\">{}</text>\n", place_x(x) + 5, top + 15, escaped(text));
}

void Figure::bars(std::span<const Interval> parts, double y, const std::string& colour, std::string_view legend) {
  constexpr double thickness = 11.0;
  live_layer(fmt::format(R"({{"kind":"bars","y":{},"colour":{},"label":{},"parts":{}}})", y, json_string(colour),
                         json_string(legend), json(parts)));
  content_ += fmt::format("<path style=\"fill:{}\" d=\"{}\"/>\n", colour,
                          boxes(parts, place_y(y) - thickness / 2, thickness, 0.75));
  legend_box(colour, legend);
}

void Figure::image(const std::string& uri, Point low, Point high) {
  const double x = place_x(low.x), y = place_y(high.y);
  content_ += fmt::format(
      "<image x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" "
      "preserveAspectRatio=\"none\" href=\"",
      x, y, place_x(high.x) - x, place_y(low.y) - y);
  (content_ += uri) += "\"/>\n";
}

// Defines one from 0 to 1 and returns what to fill with.
std::string Figure::gradient(std::span<const ColourStop> stops, std::string_view direction) {
  std::string text;
  for (const ColourStop& stop : stops)
    text += fmt::format("<stop offset=\"{:.4f}\" stop-color=\"{}\"/>", stop.at, hex(stop.colour));
  const std::string id = fmt::format("{}-{}", place_of_title, gradients_++);
  content_ += fmt::format("<defs><linearGradient id=\"{}\"{}>{}</linearGradient></defs>\n", id, direction, text);
  return fmt::format("url(#{})", id);
}

void Figure::strip(double from, double to, double y, std::span<const ColourStop> stops, std::string_view words) {
  constexpr double thickness = 18.0;
  const double left_end = place_x(from), size = place_x(to) - left_end;
  std::vector<ColourStop> parts(stops.begin(), stops.end());
  for (ColourStop& stop : parts)
    stop.at = size > 0.0 ? std::clamp((place_x(stop.at) - left_end) / size, 0.0, 1.0) : 0.0;
  const std::string fill = gradient(parts, "");
  content_ += fmt::format(
      "<rect class=\"solid\" style=\"fill:{}\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{}\"/>\n", fill,
      left_end, place_y(y) - thickness / 2, std::max(0.0, size), thickness);
  legend_ +=
      fmt::format("<text x=\"{}\" y=\"{:.1f}\" dy=\".35em\">{}</text>\n", right + 14, place_y(y), escaped(words));
}

void Figure::walls(std::span<const Wall> walls) {
  constexpr double depth = 12.0, pitch = 8.0;
  for (const Wall& wall : walls) {
    const double high = wall.part ? place_y(wall.part->begin) : top,
                 low = wall.part ? place_y(wall.part->end) : height_ - below;
    const double x = place_x(wall.at), far = x + (wall.to_the_right ? depth : -depth);
    std::string hatches;
    for (double y = high + depth; y <= low; y += pitch)
      fmt::format_to(std::back_inserter(hatches), "M{:.2f} {:.2f}L{:.2f} {:.2f}", std::min(x, far), y, std::max(x, far),
                     y - depth);
    content_ += fmt::format("<path class=\"hatch\" d=\"{}\"/><path class=\"surface\"{} d=\"M{:.2f} {}V{}\"/>\n",
                            hatches, wall.open ? " style=\"stroke-dasharray:5 4\"" : "", x, high, low);
    if (!wall.part)
      live_layer(
          fmt::format(R"({{"kind":"wall","x":{:.9g},"right":{},"open":{}}})", wall.at, wall.to_the_right, wall.open));
  }
}

void Figure::colour_bar(const ColourMap& map, const Axis& values) {
  const double bar = right + 20, bottom = height_ - below - 44, length = bottom - top;
  std::vector<ColourStop> stops;
  for (std::size_t i = 0; i < map.anchors.size(); ++i)
    stops.push_back({static_cast<double>(i) / static_cast<double>(map.anchors.size() - 1), map.anchors[i]});
  const std::string fill = gradient(stops, R"( x1="0" y1="1" x2="0" y2="0")");
  legend_ += fmt::format("<rect class=\"frame\" style=\"fill:{}\" x=\"{}\" y=\"{}\" width=\"16\" height=\"{}\"/>\n",
                         fill, bar, top, length);
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

void Figure::legend_box(const std::string& colour, std::string_view text, std::string_view kind) {
  legend_ += fmt::format("<rect class=\"{}\" style=\"fill:{}\" x=\"{}\" y=\"{}\" width=\"20\" height=\"10\"/>", kind,
                         colour, right + 14, legend_y_ - 5);
  legend_text(text);
}

void Figure::legend_note(std::string_view text) {
  live_layer(fmt::format(R"({{"kind":"note","text":{}}})", json_string(text)));
  legend_text(text, 14.0);
}

void Figure::legend_line(const Style& style, std::string_view text) {
  if (text.empty()) return;
  legend_ += fmt::format("<path class=\"line\" style=\"stroke:{};stroke-width:{}{}\" d=\"M{} {}h20\"/>", style.colour,
                         std::max(1.6, style.width), dash_css(style), right + 14, legend_y_);
  legend_text(text);
}

void Figure::legend_text(std::string_view text, double indent) {
  legend_ += fmt::format("<text x=\"{}\" y=\"{}\" dy=\".35em\">{}</text>\n", right + indent, legend_y_, escaped(text));
  legend_y_ += legend_pitch;
}

std::string Figure::svg(std::string_view title) const {
  const double bottom = height_ - below;
  std::string axes, grid;
  const Ticks along = ticks(x_, 9), up = ticks(y_, std::max(2, static_cast<int>((bottom - top) / 38)));
  for (const Tick& tick : along.ticks) {
    const double x = place_x(tick.value);
    fmt::format_to(std::back_inserter(grid), "M{:.1f} {}V{}", x, top, bottom);
    axes += fmt::format("<path class=\"frame\" d=\"M{:.1f} {}v{}\"/>", x, bottom, tick.label.empty() ? 3 : 5);
    axes += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>", x, bottom + 19, tick.label);
  }
  for (const Tick& tick : up.ticks) {
    const double y = place_y(tick.value);
    fmt::format_to(std::back_inserter(grid), "M{} {:.1f}H{}", left, y, right);
    axes += fmt::format("<path class=\"frame\" d=\"M{} {:.1f}h-{}\"/>", left, y, tick.label.empty() ? 3 : 5);
    axes +=
        fmt::format("<text x=\"{}\" y=\"{:.1f}\" dy=\".35em\" text-anchor=\"end\">{}</text>", left - 9, y, tick.label);
  }
  const std::string frame =
      fmt::format("x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"", left, top, right - left, bottom - top);
  return named_after(
      joined({fmt::format("<svg viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"{2}\">\n"
                          "<path class=\"grid\" d=\"{3}\"/>\n<svg {4} viewBox=\"{5} {6} {7} {8}\">\n",
                          width, height_, escaped(title), grid, frame, left, top, right - left, bottom - top),
              content_, "</svg>\n",
              fmt::format("<rect class=\"frame\" {0}/>\n{1}\n"
                          "<text class=\"axis\" x=\"{2}\" y=\"{3}\" text-anchor=\"middle\">{4}</text>\n"
                          "<text class=\"axis\" transform=\"rotate(-90)\" x=\"{5}\" y=\"16\" "
                          "text-anchor=\"middle\">{6}</text>\n",
                          frame, axes, (left + right) / 2, height_ - 8, escaped(x_.label) + factor(along),
                          -(top + bottom) / 2, escaped(y_.label) + factor(up)),
              legend_, "</svg>\n"}),
      title);
}

std::string Figure::live(std::string_view title) const {
  return joined({fmt::format("{{\"title\":{},\"height\":{},\"x\":{},\"y\":{},\"layers\":[\n", json_string(title),
                             height_, json(x_), json(y_)),
                 layers_, "]}"});
}

std::string Figure::file(std::string_view title) const {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"'Noto Sans', 'Liberation Sans', Arial, Helvetica, sans-serif\">\n<title>{2}</title>\n"
      "<style>{3}</style>\n<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n{4}</svg>\n",
      width, height_, escaped(title), in_light_colours(drawing_css()), in_light_colours(svg(title)));
}

std::string_view drawing_css() {
  return R"css(
svg { font-size: 13px; fill: var(--ink); overflow: hidden; }
svg text { font-variant-numeric: tabular-nums; }
svg .axis { font-size: 14px; fill: var(--soft); }
svg .note { font-size: 12px; fill: var(--soft); }
svg .grid { stroke: var(--faint); fill: none; }
svg .frame { stroke: var(--soft); fill: none; }
svg .line { fill: none; stroke-linejoin: round; stroke-linecap: butt; }
svg .band { opacity: .2; stroke: none; }
svg .body { fill: var(--soft); opacity: .25; }
svg .solid { stroke: var(--ink); stroke-width: 1; }
svg .hatch { stroke: var(--soft); stroke-width: 1; fill: none; }
svg .surface { stroke: var(--ink); stroke-width: 1.6; fill: none; }
)css";
}

}  // namespace viscobar::plot
