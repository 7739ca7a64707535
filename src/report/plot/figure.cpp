#include "report/plot/figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <iterator>
#include <ranges>

#include "report/plot/layout.hpp"
#include "text/joined.hpp"
#include "text/json_text.hpp"
#include "text/number.hpp"
#include "text/printable_text.hpp"

namespace viscobar::plot {

using namespace layout;

namespace {

/// Digits of the numbers that a marker tells. Lines are drawn to 1/1000 of a pixel: to 1/10^5 of a picture's height,
/// 1/10^6 of its width.
constexpr int digits_of_y = 5, digits_of_x = 9;

std::string json(const Axis& axis) {
  std::string text =
      fmt::format(R"({{"label":{},"low":{:.9g},"high":{:.9g})", json_string(axis.label), axis.low, axis.high);
  if (axis.scale == Scale::logarithmic) text += R"(,"log":true)";
  if (axis.bare) text += R"(,"bare":true)";
  if (!axis.link.empty()) text += fmt::format(R"(,"link":{})", json_string(axis.link));
  for (const std::string& row : axis.rows)
    text += fmt::format("{}{}", &row == &axis.rows.front() ? R"(,"rows":[)" : ",", json_string(row));
  if (!axis.rows.empty()) text += ']';
  return text + '}';
}

constexpr std::array<std::string_view, 6> outlines = {"M-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0-7 0z",
                                                      "M-3.5-3.5h7v7h-7z",
                                                      "M0-4.2l4.2 7.4h-8.4z",
                                                      "M0-4.7l4.2 4.7l-4.2 4.7l-4.2-4.7z",
                                                      "M-3.5-3.5l7 7M3.5-3.5l-7 7",
                                                      "M0 4.2l4.2-7.4h-8.4z"};

std::string marker(const std::string& colour, std::size_t shape) {
  return fmt::format("style=\"fill:{0};stroke:{0}\" d=\"{1}\"", colour, outlines[shape % outlines.size()]);
}

// The gradients of all figures of a page share one name space; svg() puts the picture's title into their names.
constexpr char place_of_title = '\x01';

std::string named_after(std::string text, std::string_view title) {
  std::string name;
  for (const char c : title) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '-';
  for (std::size_t at = 0; (at = text.find(place_of_title, at)) != text.npos;) text.replace(at, 1, name);
  return text;
}

}  // namespace

std::span<const std::string_view> marker_shapes() { return outlines; }

double height_of_bars(std::size_t rows) { return top + below + legend_pitch * static_cast<double>(rows) + 1.0; }

Figure::Figure(Axis x, Axis y, double height)
    : x_(std::move(x)), y_(std::move(y)), height_(height), left_(least_left), legend_y_(top + 10.0) {
  // Room for the widest tick beside the axis' name.
  constexpr double name_and_mark = 35.0, font = 13.0;
  for (const Tick& tick : ticks_up().ticks)
    left_ = std::max(left_, std::ceil(name_and_mark + font * of_digit * static_cast<double>(letters(tick.label))));
}

Ticks Figure::ticks_up() const { return ticks(y_, std::max(2, static_cast<int>((height_ - below - top) / 38))); }

double Figure::place_x(double value) const { return left_ + x_.position(value) * (right - left_); }
double Figure::place_y(double value) const {
  const double bottom = height_ - below;
  return bottom - y_.position(value) * (bottom - top);
}

std::string Figure::key(const std::string& colour, std::string_view legend) {
  std::string& name = keys_[colour];
  if (!legend.empty()) name = legend;
  return name.empty() ? "" : fmt::format(" data-key=\"{}\"", escaped(name));
}

std::string Figure::path(std::span<const Point> points) const {
  std::string d;
  d.reserve(16 * points.size());
  for (const Point& point : points) {
    const double x = place_x(point.x), y = place_y(point.y);
    if (!std::isfinite(x) || !std::isfinite(y)) continue;
    d += d.empty() ? 'M' : 'L';
    append_thousandths(d, x);
    d += ' ';
    append_thousandths(d, y);
  }
  return d;
}

std::string Figure::boxes(std::span<const Interval> parts, double top, double height) const {
  std::string d;
  for (const Interval& part : parts) {
    const double from = place_x(std::max(part.begin, x_.low)), to = place_x(std::min(part.end, x_.high));
    if (to < from) continue;
    d += 'M';
    append_thousandths(d, from);
    fmt::format_to(std::back_inserter(d), " {:.2f}h", top);
    append_thousandths(d, to - from);
    fmt::format_to(std::back_inserter(d), "v{}H", height);
    append_thousandths(d, from);
    d += 'z';
  }
  return d;
}

void Figure::shade(std::span<const Interval> bands, const std::string& colour, std::string_view legend) {
  const std::string d = boxes(bands, top, height_ - below - top);
  if (d.empty()) return;
  const std::string style = fmt::format("class=\"band\" style=\"fill:{0};stroke:{0}\"", colour);
  const std::string name = legend.empty() ? "" : fmt::format(" data-key=\"{}\"", escaped(legend));
  content_ += joined({"<path ", style, name, " d=\"", d, "\"/>\n"});
  if (!legend.empty()) legend_key(fmt::format("<path {} d=\"M0 -5h20v10h-20z\"/>", style), legend, name);
}

void Figure::stroke(std::span<const Point> points, const Style& style, std::string_view attributes) {
  content_ +=
      joined({"<path style=\"", stroke_css(style, style.width), "\"", attributes, " d=\"", path(points), "\"/>\n"});
}

void Figure::level(double y, const Style& style, std::string_view legend) {
  stroke(std::vector<Point>{{x_.low, y}, {x_.high, y}}, style,
         fmt::format(" class=\"level\" data-level=\"{:.9g}\"{}", y, key(style.colour, legend)));
  legend_line(style, legend);
}

void Figure::line(std::span<const Point> points, const Style& style, std::string_view legend) {
  stroke(points, style, " class=\"line\"" + key(style.colour, legend));
  legend_line(style, legend);
}

void Figure::area(std::span<const Point> lower, std::span<const Point> upper, double lift) {
  std::string d = path(lower);
  for (const Point& point : upper | std::views::reverse)
    if (std::isfinite(point.y))
      fmt::format_to(std::back_inserter(d), "L{:.2f} {:.2f}", place_x(point.x), place_y(point.y) - lift);
  content_ += joined({"<path class=\"area\" d=\"", d, "z\"/>\n"});
}

void Figure::body(double y, Interval part, bool above) {
  const double from = place_x(part.begin), to = place_x(part.end), surface = place_y(y);
  const double depth = std::clamp(above ? surface : height_ - below - surface, 0.0, 12.0);
  content_ += fmt::format(
      "<rect class=\"body\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"/>"
      "<path class=\"surface\" d=\"M{:.2f} {:.2f}H{:.2f}\"/>\n",
      from, above ? surface - depth : surface, to - from, depth, from, surface, to);
}

void Figure::markers(std::span<const Point> points, const std::string& colour, std::string_view legend,
                     std::size_t shape) {
  const std::string look = marker(colour, shape), name = key(colour, legend);
  for (const Point& point : points) {
    const double x = place_x(point.x), y = place_y(point.y);
    if (std::isfinite(x) && std::isfinite(y))
      content_ += fmt::format(
          "<path class=\"marker fixed\" transform=\"translate({:.2f} {:.2f})\" data-at=\"{:.{}g} {:.{}g}\"{} {}/>\n", x,
          y, point.x, digits_of_x, point.y, y_.significant_digits(digits_of_y), name, look);
  }
  if (!legend.empty())
    legend_key(fmt::format("<path class=\"marker\" transform=\"translate(10 0)\" {}/>", look), legend, name);
}

void Figure::series(std::span<const Point> points, const Style& style, std::string_view legend) {
  line(points, style, legend);
  markers(points, style.colour, {}, style.shape);
}

void Figure::label(Point at, std::string_view text) {
  content_ +=
      fmt::format("<text class=\"note fixed\" transform=\"translate({:.1f} {:.1f})\" x=\"6\" y=\"-6\">{}</text>\n",
                  place_x(at.x), place_y(at.y), escaped(text));
}

void Figure::marker_line(double x, const Style& style, std::string_view text) {
  stroke(std::vector<Point>{{x, y_.low}, {x, y_.high}}, style, " class=\"upright\"");
  if (text.empty()) return;
  // To the left of its line where the frame ends to the right.
  const bool leftwards = x_.position(x) > 0.5;
  content_ +=
      fmt::format("<text class=\"note fixed\" transform=\"translate({:.1f} {})\" x=\"{}\" y=\"15\"{}>{}</text>\n",
                  place_x(x), top, leftwards ? -5 : 5, leftwards ? " text-anchor=\"end\"" : "", escaped(text));
}

void Figure::bars(std::span<const Interval> parts, double y, const std::string& colour, std::string_view legend) {
  constexpr double thickness = 11.0;
  const std::string style = fmt::format("class=\"bar\" style=\"fill:{0};stroke:{0}\"", colour);
  const std::string name = fmt::format(" data-key=\"{}\"", escaped(legend));
  content_ += joined({"<path ", style, name, " d=\"", boxes(parts, place_y(y) - thickness / 2, thickness), "\"/>\n"});
  legend_key(fmt::format("<path {} d=\"M0 -5h20v10h-20z\"/>", style), legend, name, 27.0, true);
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

void Figure::strip(double from, double to, double y, std::span<const ColourStop> stops) {
  const double left_end = place_x(from), size = place_x(to) - left_end;
  std::vector<ColourStop> parts(stops.begin(), stops.end());
  for (ColourStop& stop : parts)
    stop.at = size > 0.0 ? std::clamp((place_x(stop.at) - left_end) / size, 0.0, 1.0) : 0.0;
  const std::string fill = gradient(parts, "");
  content_ += fmt::format(
      "<rect class=\"solid\" style=\"fill:{}\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{}\"/>\n", fill,
      left_end, place_y(y) - strip_thickness / 2, std::max(0.0, size), strip_thickness);
}

void Figure::block(double from, double to, double y) {
  content_ +=
      fmt::format("<rect class=\"solid rigid\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{}\"/>\n",
                  place_x(from), place_y(y) - strip_thickness / 2, place_x(to) - place_x(from), strip_thickness);
}

void Figure::joint(double at, double y) {
  constexpr double beyond = 5.0;
  content_ += fmt::format("<path class=\"joint\" d=\"M{:.2f} {:.2f}v{}\"/>\n", place_x(at),
                          place_y(y) - strip_thickness / 2 - beyond, strip_thickness + 2 * beyond);
}

void Figure::walls(std::span<const Wall> walls) {
  constexpr double depth = 12.0, pitch = 8.0;
  for (const Wall& wall : walls) {
    const double high = wall.part ? place_y(wall.part->begin) : top,
                 low = wall.part ? place_y(wall.part->end) : height_ - below;
    const double far = wall.to_the_right ? depth : -depth;
    std::string hatches;
    for (double y = depth; y <= low - high; y += pitch)
      fmt::format_to(std::back_inserter(hatches), "M{} {:.2f}L{} {:.2f}", std::min(0.0, far), y, std::max(0.0, far),
                     y - depth);
    content_ += fmt::format(
        "<g class=\"fixed\" transform=\"translate({:.2f} {:.2f})\"><path class=\"hatch\" d=\"{}\"/>"
        "<path class=\"surface\"{} d=\"M0 0V{:.2f}\"/></g>\n",
        place_x(wall.at), high, hatches, wall.open ? " style=\"stroke-dasharray:5 4\"" : "", low - high);
  }
}

std::string Figure::svg(std::string_view title) const {
  const double bottom = height_ - below;
  std::string axes, grid;
  const Ticks along = ticks(x_, 9), up = ticks_up();
  for (const Tick& tick : along.ticks) {
    const double x = place_x(tick.value);
    fmt::format_to(std::back_inserter(grid), "M{:.1f} {}V{}", x, top, bottom);
    axes += fmt::format("<path class=\"frame\" d=\"M{:.1f} {}v{}\"/>", x, bottom, tick.label.empty() ? 3 : 5);
    axes += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>", x, bottom + 19, tick.label);
  }
  for (const Tick& tick : up.ticks) {
    const double y = place_y(tick.value);
    fmt::format_to(std::back_inserter(grid), "M{:.1f} {:.1f}H{}", left_, y, right);
    axes += fmt::format("<path class=\"frame\" d=\"M{:.1f} {:.1f}h-{}\"/>", left_, y, tick.label.empty() ? 3 : 5);
    axes +=
        fmt::format("<text x=\"{}\" y=\"{:.1f}\" dy=\".35em\" text-anchor=\"end\">{}</text>", left_ - 9, y, tick.label);
  }
  // A name that is longer than the frame is high takes the whole height, and smaller letters if it must.
  const std::string name = escaped(y_.label) + factor(up);
  constexpr double font = 14.0;
  const double length = font * of_letter * static_cast<double>(letters(y_.label) + 6), room = height_ - 8.0;
  const double middle = length <= bottom - top ? (top + bottom) / 2 : height_ / 2;
  const std::string smaller = length > room ? fmt::format(" style=\"font-size:{:.1f}px\"", font * room / length) : "";
  const std::string frame =
      fmt::format("x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"", left_, top, right - left_, bottom - top);
  return named_after(
      joined({fmt::format(
                  "<svg viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"{2}\" data-x=\"{3}\" data-y=\"{4}\"{5}>\n"
                  "<path class=\"grid\" d=\"{6}\"/>\n<svg {7} viewBox=\"{8} {9} {10} {11}\">\n",
                  width, height_, escaped(title), escaped(json(x_)), escaped(json(y_)),
                  live_height_ ? fmt::format(" data-height=\"{}\"", *live_height_) : "", grid, frame, left_, top,
                  right - left_, bottom - top),
              content_, "</svg>\n",
              fmt::format("<rect class=\"frame\" {0}/>\n{1}\n"
                          "<text class=\"axis\" x=\"{2}\" y=\"{3}\" text-anchor=\"middle\">{4}</text>\n"
                          "<text class=\"axis\" transform=\"rotate(-90)\" x=\"{5}\" y=\"16\" "
                          "text-anchor=\"middle\"{7}>{6}</text>\n<g class=\"legend\">\n",
                          frame, axes, (left_ + right) / 2, height_ - 8, escaped(x_.label) + factor(along), -middle,
                          name, smaller),
              legend_, "</g>\n</svg>\n"}),
      title);
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
svg .line, svg .level, svg .upright { fill: none; stroke-linejoin: round; stroke-linecap: butt; }
svg .band { opacity: .2; stroke-width: 1; }
svg .bar { stroke-width: .75; }
svg .area { fill: var(--faint); opacity: .7; }
svg .body { fill: var(--soft); opacity: .25; }
svg .solid { stroke: var(--ink); stroke-width: 1; }
svg .rigid { fill: var(--soft); }
svg .joint { stroke: var(--ink); stroke-width: 1.6; fill: none; }
svg .hatch { stroke: var(--soft); stroke-width: 1; fill: none; }
svg .surface { stroke: var(--ink); stroke-width: 1.6; fill: none; }
)css";
}

}  // namespace viscobar::plot
