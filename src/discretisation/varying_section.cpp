#include "discretisation/varying_section.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "discretisation/gauss.hpp"

namespace viscobar {

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
  for (std::size_t e = 0; e < mesh.elements; ++e) {
    const double from = mesh.node(e), to = mesh.node(e + 1);
    Element& element = elements_.emplace_back(Element{stretch(from, to), {}});
    visit(from, to, [&](double x, double weight) {
      const double xi = along(e, x);
      double part = weight * area_(x);
      for (double& moment : element.moments) moment += part, part *= xi;
    });
    places_.push_back(places_.back() + element.size);
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
