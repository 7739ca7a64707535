// The bar, or bars in line, as they lie: points at x + s u between the walls of the ends, coloured by the stress.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "report/run/run_page.hpp"
#include "report/scene_ends.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

using plot::Axis;
using plot::Figure;
using plot::Range;

/// 1, 2 or 5 times a power of ten, not above `most`.
double rounded_down(double most) {
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double digit : {5.0, 2.0})
    if (digit * power <= most) return digit * power;
  return power;
}

double magnification(const Case& run, const ReportData& data) {
  const ThinnedField& field = data.field;
  const double length = run.scene.bar.length;
  double largest = 0.0, strain = 0.0;
  for (std::size_t row = 0; row < field.rows(); ++row) {
    const auto u = field.row(row);
    for (const ThinnedField::Part& part : field.parts())
      for (std::size_t j = part.first; j <= part.last(); ++j) {
        if (std::isfinite(u[j])) largest = std::max(largest, std::abs(u[j]));
        if (j > part.first && std::isfinite(u[j] - u[j - 1]))
          strain = std::max(strain, std::abs(u[j] - u[j - 1]) / (field.x()[j] - field.x()[j - 1]));
      }
  }
  // Walls are to be seen, too, as far as they are near.
  for (const SceneEnd& end : ends_of(run.scene))
    if (const Obstacle* wall = end.obstacle()) {
      double far = wall->gap;
      for (const double place : end.surface(field.times())) far = std::max(far, std::abs(place));
      largest = std::max(largest, std::min(far, 3.0 * largest));
    }
  for (const Member& member : run.scene.chain)
    if (member.joint.kind == JointKind::contact) largest = std::max(largest, member.joint.gap);
  if (!(largest > 0.0)) return 1.0;
  // The order of the points stays, and the bar keeps most of the picture.
  const double most = std::min(0.2 * length / largest, strain > 0.0 ? 0.6 / strain : 1e300);
  return std::isfinite(most) && most > 0.0 ? rounded_down(most) : 1.0;
}

struct Moving {
  Figure::Wall wall;
  std::vector<double> places;
};

/// Members as they lie at one of the times of the field.
class Lying {
 public:
  Lying(const ReportData& data, const AxialLayout& layout, std::size_t row)
      : field_(data.field), layout_(layout), u_(data.field.row(row)) {}

  double left(std::size_t m) const { return at_node(m, field_.parts()[m].first); }
  double right(std::size_t m) const {
    return at_node(m, field_.parts()[m].last()) + (layout_.members[m].rigid ? layout_.block : 0.0);
  }
  /// Linear between the nodes of the member.
  double place(std::size_t m, double x) const {
    const auto nodes = field_.x().begin() + static_cast<std::ptrdiff_t>(field_.parts()[m].first);
    const auto above = std::upper_bound(nodes + 1, nodes + static_cast<std::ptrdiff_t>(field_.parts()[m].count) - 1, x);
    const auto j = static_cast<std::size_t>(above - field_.x().begin());
    const double part = (x - field_.x()[j - 1]) / (field_.x()[j] - field_.x()[j - 1]);
    return (1.0 - part) * at_node(m, j - 1) + part * at_node(m, j);
  }

 private:
  double at_node(std::size_t m, std::size_t j) const {
    return field_.x()[j] + layout_.members[m].shift + layout_.magnification * u_[j];
  }

  const ThinnedField& field_;
  const AxialLayout& layout_;
  std::span<const double> u_;
};

void draw_members(Figure& figure, const ReportData& data, const AxialLayout& layout, const FieldColours& colours,
                  std::size_t row, double y, const std::string& words) {
  const ThinnedField& stress = data.stress;
  const Lying lying(data, layout, row);
  const auto values = stress.row(row);
  for (std::size_t m = 0; m < layout.members.size(); ++m) {
    const ThinnedField::Part& part = stress.parts()[m];
    if (layout.members[m].rigid) {
      figure.block(lying.left(m), lying.right(m), y);
    } else {
      std::vector<Figure::ColourStop> stops;
      const std::size_t stride = std::max<std::size_t>(1, values.size() / 60);
      for (std::size_t j = part.first; j <= part.last(); j += stride)
        stops.push_back({lying.place(m, stress.x()[j]), colours.map.at(colours.values.position(values[j]))});
      figure.strip(lying.left(m), lying.right(m), y, stops);
    }
    if (m > 0) figure.joint(0.5 * (lying.right(m - 1) + lying.left(m)), y);
  }
  figure.words_beside(y, words);
}

}  // namespace

AxialLayout axial_layout(const Case& run, const ReportData& data) {
  AxialLayout layout{.magnification = magnification(run, data), .block = 0.025 * run.scene.bar.length};
  const std::vector<Member>& chain = run.scene.chain;
  if (chain.empty()) layout.members.push_back({false, 0.0});
  double shift = !chain.empty() && chain.front().rigid() ? -layout.block : 0.0;
  for (const Member& member : chain) {
    layout.members.push_back({member.rigid(), shift});
    if (member.rigid()) shift += layout.block;
    if (member.joint.kind == JointKind::contact) shift += layout.magnification * member.joint.gap;
  }
  return layout;
}

Picture axial_bar(const Case& run, const ReportData& data, const FieldColours& colours) {
  const ThinnedField& field = data.field;
  const AxialLayout layout = axial_layout(run, data);
  const double s = layout.magnification;
  Range range;
  for (std::size_t row = 0; row < field.rows(); ++row) {
    const Lying lying(data, layout, row);
    for (std::size_t m = 0; m < layout.members.size(); ++m) range.add(lying.left(m)), range.add(lying.right(m));
  }
  std::vector<Figure::Wall> walls;
  std::vector<Moving> moving;
  std::string hidden;
  for (const SceneEnd& end : ends_of(run.scene)) {
    const Obstacle* obstacle = end.obstacle();
    if (!obstacle) continue;
    const bool above = obstacle->side == Side::above;
    const double rest = end.x + (end.name == "left" ? layout.left_shift() : layout.right_shift());
    // A wall that bounds the end on its outer side stands there whole; one on the inner side lets the bar pass.
    const Figure::Wall wall{rest + s * (above ? obstacle->gap : -obstacle->gap), above, above != (end.x > 0.0)};
    std::vector<double> places = end.surface(field.times());
    for (double& place : places) place = rest + s * place;
    if (places.empty()) places.push_back(wall.at);
    const auto [least, greatest] = std::ranges::minmax(places);
    Range with_it = range;
    if (!with_it.reach(least) || !with_it.reach(greatest)) {
      hidden += fmt::format(" The wall of the {} end lies outside.", end.name);
      continue;
    }
    range = with_it;
    if (end.input.motion)
      moving.push_back({wall, std::move(places)});
    else
      walls.push_back(wall);
  }
  const double room = 0.05 * (range.high - range.low);
  const Axis place{.label = on_page(run).heading(s == 1.0 ? "place x + u" : fmt::format("place x + {} u", readable(s)),
                                                 Dimension::length),
                   .low = range.low - room,
                   .high = range.high + room};
  const std::vector<std::size_t> rows = rows_of_few_times(field, 6);
  const Axis down{.label = "", .low = static_cast<double>(rows.size()) - 0.5, .high = -0.5, .bare = true};
  Figure figure(place, down, 60.0 + 42.0 * static_cast<double>(rows.size()));
  figure.begin_still();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    draw_members(figure, data, layout, colours, rows[k], static_cast<double>(k),
                 "t = " + on_page(run)(field.time(rows[k]), Dimension::time, 4));
    for (auto& [wall, places] : moving) {
      wall.at = places[rows[k]];
      wall.part = {static_cast<double>(k) - 0.5, static_cast<double>(k) + 0.5};
      figure.walls(std::span(&wall, 1));
    }
  }
  figure.end_still();
  figure.walls(walls);
  figure.set_live_height(150.0);
  std::string said = s == 1.0  ? "Displacements are drawn as they are."
                     : s < 1.0 ? fmt::format("Displacements are drawn {} times smaller.", readable(1.0 / s))
                               : fmt::format("Displacements are magnified by {}.", readable(s));
  const auto any = [&](auto&& is) { return std::ranges::any_of(run.scene.chain, is); };
  if (!run.scene.chain.empty()) said += " Upright strokes: joints.";
  if (any([](const Member& member) { return member.joint.kind == JointKind::contact && member.joint.gap > 0.0; }))
    said += " Gaps of joints are drawn as displacements are, to the right of where x is.";
  if (any(&Member::rigid)) said += " Grey blocks: rigid bodies, which have no length in x.";
  for (const auto& [wall, places] : moving) walls.push_back(wall);
  if (!walls.empty()) said += " Hatched: walls.";
  if (std::ranges::any_of(walls, &Figure::Wall::open))
    said += " A dashed one lets the bar pass and holds its end back.";
  return {"The bar as it lies",
          fmt::format("<span class=\"still\">The bar along its axis at a few times, time downwards, coloured by the "
                      "stress. {0}{1}</span><span class=\"live\">The bar along its axis at the time of the "
                      "slider, coloured by the stress. {0}{1}</span>",
                      said, hidden),
          {{"axial", "The bar along its axis, coloured by its stress", figure}}};
}

}  // namespace viscobar
