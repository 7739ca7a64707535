#include <algorithm>

#include "benchmark/baselines.hpp"

namespace viscobar::baseline {

namespace {

// Thomas' algorithm for the system with the marked ends held at `bound`.
void solve(const SymmetricTridiagonal& a, const std::vector<double>& b, bool left, bool right, double bound,
           std::vector<double>& pivot, std::vector<double>& x) {
  const std::size_t n = b.size();
  x = b;
  pivot[0] = left ? 1.0 : a.diagonal[0];
  if (left) x[0] = bound;
  for (std::size_t i = 1; i < n; ++i) {
    const bool held = right && i + 1 == n;
    const double below = held ? 0.0 : a.off_diagonal[i - 1], above = i == 1 && left ? 0.0 : a.off_diagonal[i - 1];
    const double factor = below / pivot[i - 1];
    if (held) x[i] = bound;
    pivot[i] = (held ? 1.0 : a.diagonal[i]) - factor * above;
    x[i] -= factor * x[i - 1];
  }
  x[n - 1] /= pivot[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) {
    const double above = i == 0 && left ? 0.0 : a.off_diagonal[i];
    x[i] = (x[i] - above * x[i + 1]) / pivot[i];
  }
}

}  // namespace

std::vector<double> paper_scheme(const BarSystem& system, double step, std::size_t steps) {
  const std::size_t n = system.size();
  const double dt = step, bound = -system.contacts().front().gap;
  SymmetricTridiagonal next, now, before;
  system.dynamic_stiffness(1 / (dt * dt), 1 / (2 * dt), 0.5, next);
  system.dynamic_stiffness(2 / (dt * dt), 0.0, 0.0, now);
  system.dynamic_stiffness(-1 / (dt * dt), 1 / (2 * dt), -0.5, before);
  const State start = system.initial_state();
  std::vector<double> u_before = start.u, u = start.u, u_next(n), right(n), product(n), pivot(n), left_end;
  for (std::size_t i = 0; i < n; ++i) u[i] += dt * start.v[i];
  u.front() = std::max(u.front(), bound);
  u.back() = std::max(u.back(), bound);
  LoadVector load(system);

  // Row of an end in A u - b: the reaction that holds it there.
  const auto reaction = [&](std::size_t end, std::size_t neighbour) {
    return next.diagonal[end] * u_next[end] + next.off_diagonal[std::min(end, neighbour)] * u_next[neighbour] -
           right[end];
  };
  left_end.push_back(u_before.front());
  for (std::size_t k = 1; k <= steps; ++k) {
    left_end.push_back(u.front());
    now.multiply(u, right);
    before.multiply(u_before, product);
    const auto f = load.at(static_cast<double>(k) * dt);
    for (std::size_t i = 0; i < n; ++i) right[i] += product[i] + f[i];
    for (const auto& [left_held, right_held] : {std::pair{false, false}, {true, false}, {false, true}, {true, true}}) {
      solve(next, right, left_held, right_held, bound, pivot, u_next);
      const bool left_fits = left_held ? reaction(0, 1) >= 0.0 : u_next.front() >= bound;
      const bool right_fits = right_held ? reaction(n - 1, n - 2) >= 0.0 : u_next.back() >= bound;
      if (left_fits && right_fits) break;
    }
    std::swap(u_before, u);
    std::swap(u, u_next);
  }
  return left_end;
}

}  // namespace viscobar::baseline
