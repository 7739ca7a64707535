#include "dynamics/load/nodal_moments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "dynamics/finite_load.hpp"
#include "dynamics/load/moments.hpp"
#include "dynamics/pieces.hpp"

namespace viscobar {

namespace {

// Those places of detail, and between them pieces that grow to either side of a stretch by no more than two: the flanks
// of a pulse have their share of its moment.
std::vector<double> graded(const NextBreak& detail, double length) {
  std::vector<double> places, all;
  for (auto at = detail(0.0, length); at; at = detail(*at, length)) places.push_back(*at);
  const auto towards_middle = [&](double from, double size, double middle) {
    for (double at = from + size; (middle - at) * size > 0.0; size *= 2.0, at += size) all.push_back(at);
  };
  for (std::size_t k = 0; k <= places.size() && !places.empty(); ++k) {
    const double a = k > 0 ? places[k - 1] : 0.0, b = k < places.size() ? places[k] : length;
    const double middle = k == 0 ? a : k == places.size() ? b : 0.5 * (a + b);
    if (k > 0) all.push_back(a);
    if (k > 1) towards_middle(a, a - places[k - 2], middle);
    if (k + 1 < places.size()) towards_middle(b, b - places[k + 1], middle);
  }
  std::ranges::sort(all);
  return all;
}

}  // namespace

// Where k jumps, or has detail that nodes do not see, int phi_i k dx / int phi_i dx: their sum has all of it.
std::vector<double> side_values(const Elements& elements, Mass mass, const SpaceFunction& f, const Places& places) {
  std::vector<double> values;
  if (!f) return values;
  const Mesh& mesh = elements.mesh();
  for (std::size_t j = 0; j < mesh.nodes(); ++j) values.push_back(f(mesh.node(j)));
  const std::vector<double> moments =
      nodal_moments(elements, mass, "the resistance of the side", f, places, Moments::of_side);
  if (moments.empty()) return values;
  const std::vector<double> weights = nodal_moments(
      elements, mass, "one", [](double) { return 1.0; }, places, Moments::of_side);
  for (std::size_t j = 0; j < values.size(); ++j)
    if (weights[j] > 0.0) values[j] = moments[j] / weights[j];
  return values;
}

// None where nothing is known; and what is smooth has none but on `fourth_order`, unless its detail is finer than a
// quarter of an element. Bonded members of unlike velocities have one by their momentum.
std::vector<double> nodal_moments(const Elements& elements, Mass mass, std::string_view what, const SpaceFunction& f,
                                  const Places& places, Moments of) {
  std::vector<double> moments;
  if (!places.breaks) return moments;
  const Mesh& mesh = elements.mesh();
  const std::vector<Piece>& pieces = elements.pieces();
  const bool velocity = of == Moments::of_velocity;
  const double length = mesh.length;
  const std::vector<double> detail = graded(places.detail, length);
  bool needed =
      places.by_moments || (mass == Mass::fourth_order && of != Moments::of_side) || places.breaks(0.0, length);
  for (std::size_t p = 1; p < pieces.size() && velocity; ++p) {
    const Piece &left = pieces[p - 1], &right = pieces[p];
    needed |= left.last() == right.first && left.velocity(left.mesh.length) != right.velocity(0.0);  // bonded
  }
  for (std::size_t k = 1; k < detail.size() && !needed; ++k) needed = detail[k] - detail[k - 1] < mesh.spacing() / 4.0;
  if (!needed) return moments;
  const auto next_detail = [&](double after, double until) -> std::optional<double> {
    const auto next = std::ranges::upper_bound(detail, after);
    return next != detail.end() && *next < until ? std::optional(*next) : std::nullopt;
  };
  const NextBreak next_break = either_of(places.breaks, next_detail);
  moments.resize(mesh.nodes());
  std::vector<double> own;
  for (const Piece& piece : pieces) {
    const auto value = [&](double x) {
      return finite_load(
          0.0, [&] { return velocity ? piece.velocity(x) : f(piece.begin + x); },
          [&] { return fmt::format("{} at x = {}", what, piece.begin + x); });
    };
    own.assign(piece.mesh.nodes(), 0.0);
    add_moments(piece.mesh, mass, piece.section.get(), 0, piece.mesh.elements, value, shifted(next_break, piece.begin),
                [&](std::size_t node, double part) { own[node] += part; });
    const double density = velocity ? piece.bar.density : 1.0;
    for (std::size_t j = 0; j < own.size(); ++j) moments[piece.first + j] += density * own[j];
    if (piece.rigid() && velocity) moments[piece.first] += piece.mass * piece.velocity(0.0);
  }
  return moments;
}

}  // namespace viscobar
