// Runs the paper's six panels in both readings by fully_discrete and by cvode, writes the pictures of docs/paper.md and
// prints its table. Run in the project's folder: build/release/tests/measure_paper docs/figures
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "report/plot/figure.hpp"
#include "report/plot/png.hpp"
#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/compare/difference.hpp"

namespace {

using namespace viscobar;

constexpr std::size_t width = 220, height = 110;

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double value) { low = std::min(low, value), high = std::max(high, value); }
};

plot::Figure field_picture(const Recording& run, const plot::Axis& time) {
  Range range;
  for (const double u : run.u) range.add(u);
  const double bound = std::max(std::abs(range.low), std::abs(range.high));
  const plot::ColourMap map = plot::diverging();
  std::array<plot::Colour, 256> palette{};
  for (std::size_t i = 0; i < palette.size(); ++i) palette[i] = map.at(static_cast<double>(i) / 255.0);
  std::vector<std::uint8_t> pixels(width * height);
  for (std::size_t i = 0; i < width; ++i) {
    const auto row = run.displacement(i * (run.times.size() - 1) / (width - 1));
    for (std::size_t j = 0; j < height; ++j) {
      const double u = row[j * (row.size() - 1) / (height - 1)];
      pixels[(height - 1 - j) * width + i] = static_cast<std::uint8_t>(std::lround(127.5 * (1.0 + u / bound)));
    }
  }
  plot::Figure figure(time, {"position x", 0.0, run.mesh.length}, 240.0);
  figure.image(plot::png_data_uri(width, height, palette, pixels), {time.low, 0.0}, {time.high, run.mesh.length});
  figure.colour_bar(map, {"displacement u", -bound, bound}, "u");
  return figure;
}

plot::Figure trace_picture(const Recording& scheme, const Recording& penalised, bool left, const plot::Axis& time) {
  const std::size_t node = left ? 0 : scheme.mesh.elements;
  Range range;
  const auto points = [&](const Recording& run) {
    std::vector<plot::Point> list;
    for (std::size_t k = 0; k < run.times.size(); ++k) {
      list.push_back({run.times[k], run.displacement(k)[node]});
      range.add(list.back().y);
    }
    return list;
  };
  const auto first = points(scheme), second = points(penalised);
  plot::Figure figure(time, plot::fitted(left ? "u(0, t)" : "u(L, t)", range.low, range.high), 150.0);
  figure.line(first, {plot::series_colour(0), false, 2.4}, "fully_discrete");
  figure.line(second, {plot::series_colour(1), true, 1.6}, "cvode, penalised");
  return figure;
}

// One picture of figures below each other, each an <svg> of its own with a viewBox.
void write_picture(const std::filesystem::path& file, const std::string& title,
                   const std::vector<plot::Figure>& figures) {
  std::string body;
  double y = 8.0, total_width = 0.0;
  for (const plot::Figure& figure : figures) {
    std::string svg = figure.svg(title);
    const auto at = svg.find("viewBox=\"") + 9;
    double box_x = 0.0, box_y = 0.0, w = 0.0, h = 0.0;
    std::sscanf(svg.c_str() + at, "%lf %lf %lf %lf", &box_x, &box_y, &w, &h);
    body += fmt::format("<svg x=\"0\" y=\"{}\" width=\"{}\" height=\"{}\"{}", y, w, h, svg.substr(4));
    y += h + 4.0;
    total_width = std::max(total_width, w);
  }
  const std::string css = plot::palette_css() + std::string(plot::drawing_css());
  std::ofstream out(file);
  out << fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\"><style>{2}</style>"
      "<rect width=\"100%\" height=\"100%\" style=\"fill: var(--paper)\"/>{3}</svg>\n",
      total_width, y + 4.0, css, body);
}

std::string contact_text(const Recording& run) {
  std::string text;
  std::size_t span = 0;
  for (const ContactPeriod& period : contact_periods(run, 0.01 * run.times.back())) {
    if (period.where == Where::span) {
      ++span;
      continue;
    }
    text += fmt::format("{}{} {:.4g}-{:.4g}", text.empty() ? "" : ", ", period.where == Where::left ? "left" : "right",
                        period.begin, period.end);
  }
  if (span) text += fmt::format("{} contacts of nodes", span);
  return text.empty() ? "none" : text;
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path folder = argc > 1 ? argv[1] : ".";
  std::filesystem::create_directories(folder);
  fmt::print(
      "| scene | contact by fully_discrete | by cvode | largest difference of the end traces, in percent of max abs u "
      "| the same, contact.restitution = 0 | = 0 and epsilon / 10 |\n|---|---|---|---|---|---|\n");
  for (const std::string reading : {"paper", "unit"}) {
    for (const std::string panel :
         {"both-ends", "both-ends-loaded", "left-end", "left-end-loaded", "span", "span-loaded"}) {
      const std::string name = reading + "-" + panel;
      Case run = read_scene("examples/scenes/" + name + ".toml").run;
      run.method = MethodName::fully_discrete;
      const Recording scheme = record(run);
      run.method = MethodName::cvode;
      const Recording penalised = record(run);
      const double largest = viscobar::largest(scheme.u);
      const auto percent = [&](const Recording& other) { return 100.0 * compare(other, scheme).end_trace / largest; };
      run.restitution = 0.0;
      const Recording damped = record(run);
      *run.epsilon /= 10.0;
      const Recording stiff = record(run);
      fmt::print("| [{0}](../examples/scenes/{0}.toml) | {1} | {2} | {3:.2g} | {4:.2g} | {5:.2g} |\n", name,
                 contact_text(scheme), contact_text(penalised), percent(penalised), percent(damped), percent(stiff));
      const plot::Axis time{"time t", 0.0, run.end};
      write_picture(folder / (name + ".svg"), run.scene.title,
                    {field_picture(scheme, time), trace_picture(scheme, penalised, true, time),
                     trace_picture(scheme, penalised, false, time)});
    }
  }
}
