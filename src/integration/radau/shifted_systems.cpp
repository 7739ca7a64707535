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
void sum_rows(const BandedMatrix& matrix, const std::vector<unsigned char>& held, std::vector<double>& sums) {
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
  if (!system.bar().side()) stiffness_.one_sided.clear(), damping_.one_sided.clear();
  held_.resize(system.size());
  nodes_.resize(system.size());
  right_.resize(system.size());
  correction_.resize(system.size());
  flag_rows(system.bar());
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
    BandedMatrix bare = drag ? damping_ : stiffness_;
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

std::optional<std::size_t> ShiftedSystems::middle_of(const BandedMatrix& inertia) {
  const std::size_t n = inertia.size(), middle = n / 2;
  const auto between = [&](std::size_t i) {
    return i >= 1 && i + 1 < n && std::ranges::none_of(inertia.one_sided, [i](const OneSidedRow& row) {
             return row.row == i || (row.leftwards ? row.row == i + 1 : row.row + 1 == i);
           });
  };
  for (std::size_t away = 0; n >= least_size && away < middle; ++away)
    for (const std::size_t i : {middle + away, middle - away})
      if (between(i)) return i;
  return std::nullopt;
}

// Nodes at which something is to be done beside what each node has.
void ShiftedSystems::flag_rows(const BarSystem& bar) {
  const std::size_t n = mass_.size();
  middle_ = middle_of(bar.inertia()).value();
  beyond_.resize(mass_.one_sided.size());
  flags_.assign(n, 0);
  for (const OneSidedRow& row : mass_.one_sided) {
    const bool right = row.row > middle_, ahead = row.leftwards == right;
    flags_[row.row] |= ahead ? amended | goes_ahead : amended | goes_back;
    const std::size_t inwards = right ? row.row - 1 : row.row + 1, outwards = right ? row.row + 1 : row.row - 1;
    flags_[ahead ? inwards : outwards] |= amended;
  }
  for (const std::size_t tie : mass_.ties) flags_[tie < middle_ ? tie : tie + 1] |= tied;
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
  const std::size_t n = nodes_.size(), middle = middle_;
  // Either end's elimination, `off` being the entry of node i and the next one, towards the right or the left.
  struct Front {
    Complex pivot, upper, coupling;
  };
  const auto lean = [&](Front& front, std::size_t off, double towards) {
    const auto of = [&](const BandedMatrix& matrix) { return matrix.skew.empty() ? 0.0 : towards * matrix.skew[off]; };
    const Complex skew = entry(of(mass_), of(damping_), of(stiffness_));
    front.upper = front.upper + skew;
    front.coupling = front.coupling - skew;
  };
  const bool skew = !mass_.skew.empty() || !stiffness_.skew.empty();
  const auto row_entry = [&](std::size_t r, std::size_t k) {
    const auto of = [&](const BandedMatrix& matrix) {
      return matrix.one_sided.empty() ? 0.0 : matrix.one_sided[r].entries[k];
    };
    return entry(of(mass_), of(damping_), of(stiffness_));
  };
  const auto begin = [&](std::size_t i, std::size_t off, bool last) {
    Front front{diagonal(i), beside(off), beside(off)};
    if (skew) lean(front, off, last ? -1.0 : 1.0);
    return front;
  };
  // Adds one-sided rows to node i and its neighbours. A row that goes ahead, where the elimination goes, has an
  // entry beyond the next node; of one that goes back the node before that is taken out.
  const auto amend = [&](Front& front, std::size_t i) {
    for (std::size_t r = 0; r < beyond_.size(); ++r) {
      const OneSidedRow& row = mass_.one_sided[r];
      const bool right = row.row > middle, ahead = row.leftwards == right;
      if (row.row == i) {
        front.pivot = front.pivot + row_entry(r, 0);
        if (ahead) front.upper = front.upper + row_entry(r, 1), beyond_[r] = row_entry(r, 2);
      } else if (ahead && i == row.column(1)) {
        front.upper = front.upper - nodes_[row.row].away * beyond_[r];
        beyond_[r] = beyond_[r] * nodes_[row.row].inverse_pivot;
      } else if (!ahead && i == row.column(1)) {
        const Node& out = nodes_[row.column(2)];
        front.coupling = front.coupling + row_entry(r, 1) - row_entry(r, 2) * out.towards;
        beyond_[r] = row_entry(r, 2) * out.inverse_pivot;
      }
    }
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
  const auto give_to_next = [&](std::size_t i, const Front& front) -> Complex {
    Node& here = nodes_[i];
    here.inverse_pivot = nothing();
    here.towards = here.away = {Lanes::Constant(-1.0), Lanes::Zero()};
    return nothing() - front.pivot;
  };
  const auto mind = [&](Front& front, std::size_t i, Complex& loss) {
    if (flags_[i] & amended) amend(front, i);
    loss = flags_[i] & tied ? give_to_next(i, front) : take_out(i, front);
  };
  Front left = begin(0, 0, false), right = begin(n - 1, n - 2, true);
  const std::size_t right_count = n - 1 - middle, both = std::min(middle, right_count);
  Complex of_left = nothing(), of_right = nothing();
  mind(left, 0, of_left);
  mind(right, n - 1, of_right);
  for (std::size_t j = 1; j < both; ++j) {
    go_on(left, of_left, j, j);
    go_on(right, of_right, n - 1 - j, n - 2 - j);
    if (flags_[j] | flags_[n - 1 - j]) {
      mind(left, j, of_left);
      mind(right, n - 1 - j, of_right);
      continue;
    }
    of_left = take_out(j, left);
    of_right = take_out(n - 1 - j, right);
  }
  for (std::size_t j = both; j < middle; ++j) {
    go_on(left, of_left, j, j);
    mind(left, j, of_left);
  }
  for (std::size_t j = both; j < right_count; ++j) {
    go_on(right, of_right, n - 1 - j, n - 2 - j);
    mind(right, n - 1 - j, of_right);
  }
  nodes_[middle].inverse_pivot = held_[middle] ? nothing() : reciprocal(diagonal(middle) - of_left - of_right);
}

void ShiftedSystems::multiply_stiffness(std::span<const double> x, std::span<double> out) const {
  const std::size_t n = nodes_.size();
  if (!stiffness_.one_sided.empty() || !stiffness_.skew.empty()) return multiply_beside(x, out);
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
  }
  for (const OneSidedRow& row : stiffness_.one_sided)
    for (std::size_t k = 1; k < 3 && !held_[row.row]; ++k)
      out[row.row] += row.entries[k] * (x[row.column(k)] - x[row.row]);
}

template <class RightSide>
void ShiftedSystems::substitute(RightSide&& right_side, std::span<Complex> x) const {
  const std::size_t n = nodes_.size(), middle = middle_;
  const auto take_beyond = [&](std::size_t i, unsigned char flag, Complex& at) {
    if (!(flags_[i] & flag)) return;
    for (std::size_t r = 0; r < beyond_.size(); ++r) {
      const OneSidedRow& row = mass_.one_sided[r];
      const bool ahead = row.leftwards == (row.row > middle);
      if (row.row == i && ahead == (flag == goes_ahead)) at = at - beyond_[r] * x[row.column(2)];
    }
  };
  Complex left = right_side(0), right = right_side(n - 1);
  x[0] = left;
  x[n - 1] = right;
  const std::size_t right_count = n - 1 - middle, both = std::min(middle, right_count);
  const auto out_left = [&](std::size_t j) {
    left = right_side(j) - nodes_[j - 1].away * left;
    take_beyond(j, goes_back, left);
    x[j] = left;
  };
  const auto out_right = [&](std::size_t j) {
    right = right_side(n - 1 - j) - nodes_[n - j].away * right;
    take_beyond(n - 1 - j, goes_back, right);
    x[n - 1 - j] = right;
  };
  std::size_t j = 1;
  for (; j < both; ++j) out_left(j), out_right(j);
  for (std::size_t i = j; i < middle; ++i) out_left(i);
  for (std::size_t i = j; i < right_count; ++i) out_right(i);
  left = right = x[middle] = nodes_[middle].inverse_pivot *
                             (right_side(middle) - nodes_[middle - 1].away * left - nodes_[middle + 1].away * right);
  const auto in_left = [&](std::size_t i) {
    left = nodes_[i].inverse_pivot * x[i] - nodes_[i].towards * left;
    take_beyond(i, goes_ahead, left);
    x[i] = left;
  };
  const auto in_right = [&](std::size_t k) {
    right = nodes_[k].inverse_pivot * x[k] - nodes_[k].towards * right;
    take_beyond(k, goes_ahead, right);
    x[k] = right;
  };
  std::size_t i = middle, k = middle + 1;
  for (; i > both; --i) in_left(i - 1);
  for (; n - k > both; ++k) in_right(k);
  for (; i > 0; --i, ++k) in_left(i - 1), in_right(k);
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
  for (std::size_t r = 0; r < mass_.one_sided.size() && (flags_[i] & (goes_ahead | goes_back)); ++r) {
    const OneSidedRow& row = mass_.one_sided[r];
    if (row.row != i) continue;
    for (std::size_t k = 0; k < 3; ++k) inertia = inertia + times(row.entries[k], x[row.column(k)]);
    for (std::size_t k = 1; k < 3 && !stiffness_.one_sided.empty(); ++k)
      sum = sum -
            elastic(damping_.one_sided[r].entries[k], stiffness_.one_sided[r].entries[k]) * (x[row.column(k)] - x[i]);
  }
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
