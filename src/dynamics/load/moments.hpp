#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>

#include "discretisation/gauss.hpp"
#include "discretisation/varying_section.hpp"
#include "viscobar/discretisation/mass.hpp"
#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// Breaks of f(begin + x).
inline NextBreak shifted(const NextBreak& breaks, double begin) {
  if (begin == 0.0) return breaks;
  return [&breaks, begin](double after, double until) -> std::optional<double> {
    const auto next = breaks(begin + after, begin + until);
    return next ? std::optional(*next - begin) : std::nullopt;
  };
}

/// Calls add(i, int phi_i f dx) with the parts of the elements [first, last): Gauss' formula of four points between the
/// nodes and the breaks of f and of the section. `next(after, until)` is the first of f there, or nothing. Under
/// `paper`, which has a whole weight at the ends, their entries count twice: M f of a constant f is what it is
/// elsewhere. With a section they are int A phi_i f dx, and phi_i those of VaryingSection.
template <class Function, class Next, class Add>
void add_moments(const Mesh& mesh, Mass mass, const VaryingSection* section, std::size_t first, std::size_t last,
                 Function&& f, Next&& next, Add&& add) {
  const double rounding = 64.0 * std::numeric_limits<double>::epsilon() * mesh.length, end = mesh.node(last);
  std::size_t searches = 1000 + 2 * mesh.elements;  // without end where breaks have a limit, as those of sin(1/x) > 0
  const auto search = [&](double after) {
    if (!(after < end)) return end;
    const double of_section = section ? section->next_break(after, end) : end;
    if (searches == 0) return of_section;
    --searches;
    return std::min(of_section, std::optional<double>(next(after, end)).value_or(end));
  };
  double stop = search(mesh.node(first));
  for (std::size_t e = first; e < last; ++e) {
    const double a = mesh.node(e), b = mesh.node(e + 1);
    double before = 0.0, after = 0.0;
    for (double low = a, high = a; high < b; low = high) {
      high = std::min(stop, b);
      if (stop <= high) stop = search(stop + rounding);
      const double half = 0.5 * (high - low);
      for (const auto [node, weight] : gauss(half > 0.0 ? 4 : 0)) {
        const double x = low + half * (1.0 + node);
        const double share = section ? section->along(e, x) : (x - a) / (b - a);
        const double part = half * weight * f(x) * (section ? section->area(x) : 1.0);
        before += (1.0 - share) * part;
        after += share * part;
      }
    }
    add(e, mass == Mass::paper && e == 0 ? 2.0 * before : before);
    add(e + 1, mass == Mass::paper && e + 1 == mesh.elements ? 2.0 * after : after);
  }
}

}  // namespace viscobar
