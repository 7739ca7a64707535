#include "discretisation/varying_section.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "discretisation/gauss.hpp"

namespace viscobar {

namespace {

constexpr std::size_t points = 16;
using Row = std::array<double, points>;

// rows[i] has the weights of values at Gauss' points x_j for their polynomial's integral from -1 to x_i. With
// Legendre's polynomials P_n that is, (2n+1) int P_n being P_{n+1} - P_{n-1},
//
//     w_j ((1 + x_i) / 2 + sum_{n >= 1} P_n(x_j) (P_{n+1}(x_i) - P_{n-1}(x_i)) / 2).
const std::array<Row, points>& running_integrals() {
  static const auto made = [] {
    const auto formula = gauss(points);
    std::array<std::array<double, points + 1>, points> legendre;  // of each point
    for (std::size_t i = 0; i < points; ++i) {
      auto& p = legendre[i];
      p[0] = 1.0, p[1] = formula[i].node;
      for (std::size_t n = 1; n < points; ++n) {
        const auto degree = static_cast<double>(n);
        p[n + 1] = ((2.0 * degree + 1.0) * p[1] * p[n] - degree * p[n - 1]) / (degree + 1.0);
      }
    }
    std::array<Row, points> rows;
    for (std::size_t i = 0; i < points; ++i)
      for (std::size_t j = 0; j < points; ++j) {
        double sum = 1.0 + formula[i].node;
        for (std::size_t n = 1; n < points; ++n) sum += legendre[j][n] * (legendre[i][n + 1] - legendre[i][n - 1]);
        rows[i][j] = 0.5 * formula[j].weight * sum;
      }
    return rows;
  }();
  return made;
}

}  // namespace

// Calls add(x, weight) for the points of a formula for int f dx.
template <class Add>
void VaryingSection::visit(double from, double to, Add&& add) const {
  for (auto next = std::ranges::upper_bound(breaks_, from); from < to;) {
    const double until = next == breaks_.end() ? to : std::min(*next++, to);
    const double half = 0.5 * (until - from), middle = from + half;
    for (const auto [node, weight] : gauss(10)) add(middle + half * node, half * weight);
    from = until;
  }
}

double VaryingSection::stretch(double from, double to) const {
  double sum = 0.0;
  visit(from, to, [&](double x, double weight) { sum += weight / area_(x); });
  return sum;
}

VaryingSection::VaryingSection(std::function<double(double)> area, const Breaks& breaks, const Mesh& mesh)
    : area_(std::move(area)), mesh_(mesh), places_(1, 0.0) {
  const double rounding = 64.0 * std::numeric_limits<double>::epsilon() * mesh.length;
  std::size_t searches = 1000 + 2 * mesh.elements;  // breaks may have a limit
  for (auto at = breaks ? breaks(0.0, mesh.length) : std::nullopt; at && searches-- > 0;
       at = breaks(*at + rounding, mesh.length))
    breaks_.push_back(*at);
  const auto formula = gauss(points);
  const std::array<Row, points>& running = running_integrals();
  for (std::size_t e = 0; e < mesh.elements; ++e) {
    Element& element = elements_.emplace_back();  // its moments of s at first
    double s = 0.0;
    for (double from = mesh.node(e), until; from < mesh.node(e + 1); from = until) {
      until = next_break(from, mesh.node(e + 1));
      const double half = 0.5 * (until - from), middle = from + half;
      Row areas, stretches;
      for (std::size_t i = 0; i < points; ++i) {
        areas[i] = area_(middle + half * formula[i].node);
        stretches[i] = half / areas[i];
      }
      double whole = 0.0;
      for (std::size_t i = 0; i < points; ++i) {
        double here = s, part = half * formula[i].weight * areas[i];
        for (std::size_t j = 0; j < points; ++j) here += running[i][j] * stretches[j];
        whole += formula[i].weight * stretches[i];
        for (double& moment : element.moments) moment += part, part *= here;
      }
      s += whole;
    }
    element.size = s;
    double power = 1.0;
    for (double& moment : element.moments) moment /= power, power *= s;
    places_.push_back(places_.back() + s);
  }
}

double VaryingSection::along(std::size_t element, double x) const {
  return stretch(mesh_.node(element), x) / elements_[element].size;
}

double VaryingSection::next_break(double after, double until) const {
  const auto next = std::upper_bound(breaks_.begin(), breaks_.end(), after);
  return next == breaks_.end() ? until : std::min(*next, until);
}

}  // namespace viscobar
