#include <algorithm>

#include "benchmark/baselines.hpp"
#include "viscobar/dynamics/load_vector.hpp"

namespace viscobar::baseline {

namespace {

// Thomas' algorithm for the system with the marked ends held at `bound`.
void solve(const BandedMatrix& a, const std::vector<double>& b, bool left, bool right, double bound,
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
  BandedMatrix next, now, before;
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

std::vector<double> plain_scheme(const BarSystem& system, double step, std::size_t steps) {
  const std::size_t n = system.size(), last = n - 1;
  const double dt = step, bound = -system.contacts().front().gap;
  BandedMatrix next, now, before;
  system.dynamic_stiffness(1 / (dt * dt), 1 / (2 * dt), 0.5, next);
  system.dynamic_stiffness(2 / (dt * dt), 0.0, 0.0, now);
  system.dynamic_stiffness(-1 / (dt * dt), 1 / (2 * dt), -0.5, before);
  std::vector<double> lower(n), inverse(n), upper(n);
  for (std::size_t i = 0; i < n; ++i) {
    lower[i] = i == 0 ? 0.0 : next.off_diagonal[i - 1] * inverse[i - 1];
    inverse[i] = 1.0 / (next.diagonal[i] - (i == 0 ? 0.0 : lower[i] * next.off_diagonal[i - 1]));
    upper[i] = i == last ? 0.0 : next.off_diagonal[i] * inverse[i];
  }
  const auto back = [&](std::vector<double>& x) {
    x[last] *= inverse[last];
    for (std::size_t i = last; i-- > 0;) x[i] = x[i] * inverse[i] - upper[i] * x[i + 1];
  };
  const auto column = [&](std::size_t end) {
    std::vector<double> x(n, 0.0);
    x[end] = 1.0;
    for (std::size_t i = 1; i < n; ++i) x[i] -= lower[i] * x[i - 1];
    back(x);
    return x;
  };
  const std::vector<double> first = column(0), other = column(last);
  const double g00 = first[0], g01 = first[last], g11 = other[last];
  const State start = system.initial_state();
  std::vector<double> u_before = start.u, u = start.u, x(n), left_end;
  for (std::size_t i = 0; i < n; ++i) u[i] += dt * start.v[i];
  u.front() = std::max(u.front(), bound), u.back() = std::max(u.back(), bound);
  LoadVector load(system);
  const auto f = load.at(0.0);  // which does not depend on t
  left_end.reserve(steps + 1);
  left_end.push_back(u_before.front());
  for (std::size_t k = 1; k <= steps; ++k) {
    left_end.push_back(u.front());
    double swept = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      double b = f[i] + now.diagonal[i] * u[i] + before.diagonal[i] * u_before[i];
      if (i > 0) b += now.off_diagonal[i - 1] * u[i - 1] + before.off_diagonal[i - 1] * u_before[i - 1];
      if (i < last) b += now.off_diagonal[i] * u[i + 1] + before.off_diagonal[i] * u_before[i + 1];
      x[i] = swept = b - lower[i] * swept;
    }
    back(x);
    const double e0 = x[0] - bound, e1 = x[last] - bound;
    if (e0 < 0.0 || e1 < 0.0) {
      double p = std::max(-e0 / g00, 0.0), q = 0.0;
      if (e1 + g01 * p < 0.0) {
        p = 0.0, q = -e1 / g11;
        if (e0 + g01 * q < 0.0) {
          const double determinant = g00 * g11 - g01 * g01;
          p = (g01 * e1 - g11 * e0) / determinant, q = (g01 * e0 - g00 * e1) / determinant;
        }
      }
      for (std::size_t i = 0; i < n; ++i) x[i] += p * first[i] + q * other[i];
    }
    std::swap(u_before, u);
    std::swap(u, x);
  }
  return left_end;
}

}  // namespace viscobar::baseline
