#include "integration/radau/shifted_systems.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace viscobar::radau {

namespace {

inline Complex reciprocal(const Complex& a) {
  const Lanes scale = 1.0 / (a.re * a.re + a.im * a.im);
  return {a.re * scale, -a.im * scale};
}

// 0 where rounding can explain them.
void sum_rows(const SymmetricTridiagonal& matrix, const std::vector<unsigned char>& held, std::vector<double>& sums) {
  const std::size_t n = matrix.size();
  sums.assign(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    if (held[i]) continue;
    double sum = matrix.diagonal[i];
    if (i > 0) sum += matrix.off_diagonal[i - 1];
    if (i + 1 < n) sum += matrix.off_diagonal[i];
    if (std::abs(sum) > 8.0 * std::numeric_limits<double>::epsilon() * matrix.diagonal[i]) sums[i] = sum;
  }
}

inline Complex nothing() { return {Lanes::Zero(), Lanes::Zero()}; }

}  // namespace

void ShiftedSystems::take(const PenalisedSystem& system) {
  system.dynamic_stiffness(1.0, 0.0, 0.0, mass_);
  system.dynamic_stiffness(0.0, 1.0, 0.0, damping_);
  system.dynamic_stiffness(0.0, 0.0, 1.0, stiffness_);
  if (!system.bar().side()) stiffness_.end_rows.reset(), damping_.end_rows.reset();
  held_.resize(system.size());
  nodes_.resize(system.size());
  right_.resize(system.size());
  correction_.resize(system.size());
  for (std::size_t i = 0; i < held_.size(); ++i) {
    held_[i] = std::isinf(mass_.diagonal[i]) ? 1 : 0;
    if (held_[i]) stiffness_.diagonal[i] = damping_.diagonal[i] = mass_.diagonal[i] = 0.0;
  }
  if (const SideRows* side = system.bar().side()) return sum_rows_beside(system.bar(), *side);
  sum_rows(stiffness_, held_, bound_);
  sum_rows(damping_, held_, dashed_);
}

// The sums of the side's rows apart, which are as small beside E/h as those of the inertia.
void ShiftedSystems::sum_rows_beside(const BarSystem& bar, const SideRows& side) {
  const std::size_t first = bar.first_node(), n = bar.size();
  for (const bool drag : {false, true}) {
    SymmetricTridiagonal bare = drag ? damping_ : stiffness_;
    side.add_to(bare, first, drag ? -1.0 : 0.0, drag ? 0.0 : -1.0);
    std::vector<double>& sums = drag ? dashed_ : bound_;
    sum_rows(bare, held_, sums);
    const auto coefficient = [&](std::size_t j) {
      return j < first || j - first >= n ? 0.0 : drag ? -side.drag(j) : -side.stiffness(j);
    };
    side.subtract(coefficient, first, n, sums);
    for (std::size_t i = 0; i < n; ++i)
      if (held_[i]) sums[i] = 0.0;
  }
}

void ShiftedSystems::factorise(double h) {
  h_ = h;
  double largest = 0.0;  // of elasticity and damping, beside the inertia of the poles, which are some 10
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (mass_.diagonal[i] > 0.0)
      largest =
          std::max(largest, (h * damping_.diagonal[i] + 0.1 * h * h * stiffness_.diagonal[i]) / mass_.diagonal[i]);
  rounding_ = 300.0 * std::numeric_limits<double>::epsilon() * (1.0 + 0.1 * largest);
  const Formula& formula = Formula::get();
  const Complex of_mass = formula.poles, of_stiffness = {h * h * formula.inverse.re, h * h * formula.inverse.im};
  const auto entry = [&](double m, double c, double k) -> Complex {
    return {of_mass.re * m + of_stiffness.re * k + h * c, of_mass.im * m + of_stiffness.im * k};
  };
  const auto diagonal = [&](std::size_t i) {
    return entry(mass_.diagonal[i], damping_.diagonal[i], stiffness_.diagonal[i]);
  };
  const auto beside = [&](std::size_t i) {
    return entry(mass_.off_diagonal[i], damping_.off_diagonal[i], stiffness_.off_diagonal[i]);
  };
  const std::size_t n = nodes_.size(), middle = n / 2;
  // Either end's elimination, `off` being the entry of node i and the next one, towards the right or the left.
  struct Front {
    Complex pivot, upper, coupling;
  };
  const auto lean = [&](Front& front, std::size_t off, double towards) {
    const auto of = [&](const SymmetricTridiagonal& matrix) {
      return matrix.skew.empty() ? 0.0 : towards * matrix.skew[off];
    };
    const Complex skew = entry(of(mass_), of(damping_), of(stiffness_));
    front.upper = front.upper + skew;
    front.coupling = front.coupling - skew;
  };
  const bool skew = !mass_.skew.empty() || !stiffness_.skew.empty();
  const auto row_entry = [&](bool last, std::size_t k) {
    const auto of = [&](const SymmetricTridiagonal& matrix) {
      return !matrix.end_rows ? 0.0 : last ? matrix.end_rows->last[k] : matrix.end_rows->first[k];
    };
    return entry(of(mass_), of(damping_), of(stiffness_));
  };
  const auto begin = [&](std::size_t i, std::size_t off, bool last, Complex& beyond) {
    Front front{diagonal(i), beside(off), beside(off)};
    if (skew) lean(front, off, last ? -1.0 : 1.0);
    beyond = nothing();
    if (mass_.end_rows) {
      front.pivot = front.pivot + row_entry(last, 0);
      front.upper = front.upper + row_entry(last, 1);
      beyond = row_entry(last, 2);
    }
    return front;
  };
  // Takes node i out; gives what the diagonal of the next one loses. A call would pass the front through memory.
  const auto take_out = [&](std::size_t i, const Front& front) __attribute__((always_inline)) {
    Node& here = nodes_[i];
    here.inverse_pivot = held_[i] ? nothing() : reciprocal(front.pivot);
    here.towards = front.upper * here.inverse_pivot;
    here.away = front.coupling * here.inverse_pivot;
    return here.away * front.upper;
  };
  const auto go_on = [&](Front& front, const Complex& loss, std::size_t i, std::size_t off) {
    front = {diagonal(i) - loss, beside(off), beside(off)};
    if (skew) lean(front, off, off == i ? 1.0 : -1.0);
  };
  Front left = begin(0, 0, false, beyond_first_), right = begin(n - 1, n - 2, true, beyond_last_);
  const std::size_t right_count = n - 1 - middle;  // `middle`, or one less
  Complex of_left = take_out(0, left), of_right = take_out(n - 1, right);
  for (std::size_t j = 1; j < right_count; ++j) {
    go_on(left, of_left, j, j);
    go_on(right, of_right, n - 1 - j, n - 2 - j);
    if (j == 1 && mass_.end_rows) {
      left.upper = left.upper - nodes_[0].away * beyond_first_;
      right.upper = right.upper - nodes_[n - 1].away * beyond_last_;
    }
    of_left = take_out(j, left);
    of_right = take_out(n - 1 - j, right);
  }
  if (right_count < middle) {
    go_on(left, of_left, middle - 1, middle - 1);
    of_left = take_out(middle - 1, left);
  }
  beyond_first_ = beyond_first_ * nodes_[0].inverse_pivot;
  beyond_last_ = beyond_last_ * nodes_[n - 1].inverse_pivot;
  nodes_[middle].inverse_pivot = held_[middle] ? nothing() : reciprocal(diagonal(middle) - of_left - of_right);
}

void ShiftedSystems::multiply_stiffness(std::span<const double> x, std::span<double> out) const {
  const std::size_t n = nodes_.size();
  if (stiffness_.end_rows || !stiffness_.skew.empty()) return multiply_beside(x, out);
  double before = 0.0;  // pull of the element on the left
  for (std::size_t i = 0; i < n; ++i) {
    const double pull = i + 1 < n ? stiffness_.off_diagonal[i] * (x[i + 1] - x[i]) : 0.0;
    out[i] = held_[i] ? 0.0 : bound_[i] * x[i] + (pull - before);
    before = pull;
  }
}

void ShiftedSystems::multiply_beside(std::span<const double> x, std::span<double> out) const {
  const std::size_t n = nodes_.size();
  for (std::size_t i = 0; i < n; ++i) {
    out[i] = 0.0;
    if (held_[i]) continue;
    out[i] = bound_[i] * x[i];
    if (i > 0) out[i] += stiffness_.below(i - 1) * (x[i - 1] - x[i]);
    if (i + 1 < n) out[i] += stiffness_.above(i) * (x[i + 1] - x[i]);
    if (!stiffness_.end_rows || (i > 0 && i + 1 < n)) continue;
    for (std::size_t k = 1; k < 3; ++k) out[i] += stiffness_.end_rows->row(i)[k] * (x[i == 0 ? k : i - k] - x[i]);
  }
}

template <class RightSide>
void ShiftedSystems::substitute(RightSide&& right_side, std::span<Complex> x) const {
  const std::size_t n = nodes_.size(), middle = n / 2;
  Complex left = right_side(0), right = right_side(n - 1);
  x[0] = left;
  x[n - 1] = right;
  const std::size_t right_count = n - 1 - middle;  // middle or one less
  std::size_t j = 1;
  for (; j < right_count; ++j) {
    left = right_side(j) - nodes_[j - 1].away * left;
    right = right_side(n - 1 - j) - nodes_[n - j].away * right;
    x[j] = left;
    x[n - 1 - j] = right;
  }
  for (; j < middle; ++j) x[j] = left = right_side(j) - nodes_[j - 1].away * left;
  left = right = x[middle] = nodes_[middle].inverse_pivot *
                             (right_side(middle) - nodes_[middle - 1].away * left - nodes_[middle + 1].away * right);
  std::size_t i = middle;
  if (right_count < middle) {
    --i;
    x[i] = left = nodes_[i].inverse_pivot * x[i] - nodes_[i].towards * left;
  }
  for (std::size_t k = middle + 1; i > 0; ++k) {
    --i;
    x[i] = left = nodes_[i].inverse_pivot * x[i] - nodes_[i].towards * left;
    x[k] = right = nodes_[k].inverse_pivot * x[k] - nodes_[k].towards * right;
  }
  if (!mass_.end_rows) return;
  x[0] = x[0] - beyond_first_ * x[2];
  x[n - 1] = x[n - 1] - beyond_last_ * x[n - 3];
}

// Row i of right_side - D x.
Complex ShiftedSystems::residual(std::size_t i, const Complex& right_side, std::span<const Complex> x) const {
  if (held_[i]) return nothing();
  const std::size_t n = nodes_.size();
  const Formula& formula = Formula::get();
  const double h = h_;
  const Complex of_mass = formula.poles, of_stiffness = {h * h * formula.inverse.re, h * h * formula.inverse.im};
  const auto elastic = [&](double c, double k) -> Complex {
    return {of_stiffness.re * k + h * c, of_stiffness.im * k};
  };
  const auto times = [](double m, const Complex& z) -> Complex { return {m * z.re, m * z.im}; };
  Complex inertia = times(mass_.diagonal[i], x[i]);
  Complex sum = right_side - elastic(dashed_[i], bound_[i]) * x[i];
  if (i > 0) {
    inertia = inertia + times(mass_.below(i - 1), x[i - 1]);
    sum = sum - elastic(damping_.below(i - 1), stiffness_.below(i - 1)) * (x[i - 1] - x[i]);
  }
  if (i + 1 < n) {
    inertia = inertia + times(mass_.above(i), x[i + 1]);
    sum = sum - elastic(damping_.above(i), stiffness_.above(i)) * (x[i + 1] - x[i]);
  }
  if (mass_.end_rows && i == 0)
    for (std::size_t k = 0; k < 3; ++k) inertia = inertia + times(mass_.end_rows->first[k], x[k]);
  if (mass_.end_rows && i + 1 == n)
    for (std::size_t k = 0; k < 3; ++k) inertia = inertia + times(mass_.end_rows->last[k], x[n - 1 - k]);
  if (stiffness_.end_rows && (i == 0 || i + 1 == n))
    for (std::size_t k = 1; k < 3; ++k)
      sum =
          sum - elastic(damping_.end_rows->row(i)[k], stiffness_.end_rows->row(i)[k]) * (x[i == 0 ? k : i - k] - x[i]);
  return sum - of_mass * inertia;
}

void ShiftedSystems::solve(std::span<const double> force, std::span<const double> stiff_rate, bool loaded,
                           std::span<Complex> x) {
  const Formula& formula = Formula::get();
  const double h = h_;
  const Lanes re = -h * h * formula.inverse.re, im = -h * h * formula.inverse.im;
  const auto unloaded = [&](std::size_t i) -> Complex {
    return {re * stiff_rate[i] + h * force[i], im * stiff_rate[i]};
  };
  if (!refines_) {
    if (loaded)
      substitute([&](std::size_t i) { return unloaded(i) + x[i]; }, x);
    else
      substitute(unloaded, x);
    return;
  }
  const std::size_t n = nodes_.size();
  for (std::size_t i = 0; i < n; ++i) right_[i] = loaded ? unloaded(i) + x[i] : unloaded(i);
  substitute([&](std::size_t i) { return right_[i]; }, x);
  for (std::size_t i = 0; i < n; ++i) correction_[i] = residual(i, right_[i], x);
  substitute([&](std::size_t i) { return correction_[i]; }, correction_);
  for (std::size_t i = 0; i < n; ++i) x[i] = x[i] + correction_[i];
}

}  // namespace viscobar::radau
