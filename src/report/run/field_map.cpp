#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "report/plot/png.hpp"
#include "report/run/run_page.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

double mixed(double a, double b, double weight) { return a + weight * (b - a); }

/// Where a position lies among increasing values: the index below it and the part of the way to the next.
struct Place {
  std::size_t index;
  double weight;
};
template <class Values>
Place locate(const Values& values, std::size_t count, double at, std::size_t from) {
  if (count < 2) return {0, 0.0};
  std::size_t i = from;
  while (i + 2 < count && values(i + 1) <= at) ++i;
  return {i, std::clamp((at - values(i)) / (values(i + 1) - values(i)), 0.0, 1.0)};
}

/// Pixels for values along an axis: so many for each that they are fine enough, with colours that are straight lines in
/// between, and no more than a screen shows.
std::size_t pixels_of(std::size_t values, std::size_t enough, std::size_t most) {
  return std::min(most, values * ((enough + values - 1) / values));
}

}  // namespace

FieldColours colours_of(const ThinnedField& field, const std::string& label, bool about_zero) {
  const plot::Range range = field.range();
  const double size = std::max(range.high, -range.low);
  plot::Range scale{above_rounding(range.low, size), above_rounding(range.high, size)};
  const bool two_signs = about_zero || std::min(range.high, -range.low) > 0.1 * size;
  if (two_signs) {
    scale.add(-range.low);
    scale.add(-range.high);
  }
  plot::Axis values{label, scale.low, scale.high};
  if (!(scale.high - scale.low > 1e-12 * std::max(std::abs(scale.low), std::abs(scale.high))))
    values = scale.axis(values.label);
  return {two_signs ? plot::diverging() : plot::sequential(), values, range};
}

plot::Axis time_axis(const ThinnedField& field, const NumberText& number) {
  return {.label = number.heading("time t", Dimension::time),
          .low = field.time(0),
          .high = field.time(field.rows() - 1),
          .link = "t"};
}

plot::Figure map_figure(const Case& run, const ThinnedField& field, const FieldColours& colours_of_field,
                        std::string_view symbol) {
  const std::size_t width = pixels_of(field.rows(), 200, 480), height = pixels_of(field.x().size(), 100, 300);
  constexpr int colours = 255, touching = 255;
  const NumberText number = NumberText::page(run.scene);
  const auto& [map, values, range, contact_up_to, contact_from] = colours_of_field;
  std::array<plot::Colour, 256> palette{};
  for (std::size_t i = 0; i < colours; ++i) palette[i] = map.at(static_cast<double>(i) / (colours - 1));
  palette[touching] = FieldColours::touching;
  std::vector<std::uint8_t> pixels(width * height);
  const plot::Axis time = time_axis(field, number);
  const double length = run.scene.bar.length;
  std::vector<Place> in_time(width);
  for (std::size_t i = 0; i < width; ++i)
    in_time[i] = locate([&](std::size_t k) { return field.time(k); }, field.rows(),
                        mixed(time.low, time.high, (static_cast<double>(i) + 0.5) / static_cast<double>(width)),
                        i == 0 ? 0 : in_time[i - 1].index);
  // Two neighbouring nodes at the times of the pixels: what lies between them is arithmetic on whole rows of pixels.
  std::vector<double> of_node(field.rows());
  const auto at_node = [&](std::size_t node, std::vector<double>& over_time) {
    for (std::size_t k = 0; k < of_node.size(); ++k) of_node[k] = field.row(k)[std::min(node, field.x().size() - 1)];
    for (std::size_t i = 0; i < width; ++i)
      over_time[i] = mixed(of_node[in_time[i].index], of_node[in_time[i].index + 1], in_time[i].weight);
  };
  std::vector<double> left(width), right(width);
  std::size_t node = 0;
  at_node(node, left);
  at_node(node + 1, right);
  Place in_space{0, 0.0};
  for (std::size_t j = 0; j < height; ++j) {
    in_space = locate([&](std::size_t k) { return field.x()[k]; }, field.x().size(),
                      length * (static_cast<double>(j) + 0.5) / static_cast<double>(height), in_space.index);
    while (node < in_space.index) {
      left.swap(right);
      at_node(++node + 1, right);
    }
    // By numbers that no pixel can change, and without a branch: so the compiler takes many pixels at a time.
    std::transform(left.begin(), left.end(), right.begin(), pixels.begin() + (height - 1 - j) * width,
                   [weight = in_space.weight, low = values.low, size = values.high - values.low, up_to = contact_up_to,
                    from = contact_from](double at_left, double at_right) {
                     const double value = mixed(at_left, at_right, weight);
                     const double part = std::clamp((value - low) / size, 0.0, 1.0);
                     const int colour = static_cast<int>(part * (colours - 1) + 0.5);
                     return static_cast<std::uint8_t>((value <= up_to) | (value >= from) ? touching : colour);
                   });
  }
  const plot::Axis position{
      .label = number.heading("position x", Dimension::length), .low = 0.0, .high = length, .link = "x"};
  plot::Figure figure(time, position, 400.0);
  figure.image(plot::png_data_uri(width, height, palette, pixels), {time.low, 0.0}, {time.high, length});
  // A strip a bar, its edge to be seen on light and on dark.
  double place = 0.0;
  for (const Member& member : run.scene.chain)
    if ((place += member.bar.length) > 0.0 && !member.rigid() && &member != &run.scene.chain.back())
      for (const plot::Style& line : {plot::Style{"var(--paper)", false, 3.0}, plot::Style{"var(--ink)", false, 1.0}})
        figure.level(place, line);
  figure.colour_bar(map, values, symbol);
  if (std::ranges::find(pixels, touching) != pixels.end())
    figure.legend_box(plot::hex(palette[touching]), "in contact");
  return figure;
}

std::string map_remark(const Case& run, const ThinnedField& field, const FieldColours& colours, const char* what) {
  std::string text;
  if (colours.values.low == -colours.values.high) text += " The pale middle of the scale is zero.";
  const auto every = [](std::size_t stride, const char* one) {
    return stride == 1 ? fmt::format("every {}", one) : fmt::format("every {} {}", ordinal(stride), one);
  };
  if (field.time_stride() > 1 || field.node_stride() > 1)
    text += fmt::format(" Drawn from {} and {}{}.", every(field.time_stride(), "output time"),
                        every(field.node_stride(), what), run.files.field ? "; field.h5 has them all" : "");
  return text;
}

std::vector<std::size_t> rows_of_few_times(const ThinnedField& field, std::size_t count) {
  std::vector<std::size_t> rows;
  const double begin = field.time(0), end = field.time(field.rows() - 1);
  for (std::size_t k = 0, row = 0; k < count; ++k) {
    const double t = mixed(begin, end, static_cast<double>(k) / static_cast<double>(count - 1));
    while (row + 1 < field.rows() && std::abs(field.time(row + 1) - t) <= std::abs(field.time(row) - t)) ++row;
    if (rows.empty() || rows.back() != row) rows.push_back(row);
  }
  return rows;
}

}  // namespace viscobar
