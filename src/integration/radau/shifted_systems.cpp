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
void sum_rows(const BandedMatrix& matrix, std::vector<double>& sums) {
  const std::size_t n = matrix.size();
  sums.resize(n);
  const double *const diagonal = matrix.diagonal.data(), *const off = matrix.off_diagonal.data();
  double* const out = sums.data();
  const auto known = [diagonal](std::size_t i, double sum) {
    return std::abs(sum) > 8.0 * std::numeric_limits<double>::epsilon() * diagonal[i] ? sum : 0.0;
  };
  out[0] = known(0, diagonal[0] + off[0]);
#pragma GCC ivdep
  for (std::size_t i = 1; i < n - 1; ++i) out[i] = known(i, diagonal[i] + off[i - 1] + off[i]);
  out[n - 1] = known(n - 1, diagonal[n - 1] + off[n - 2]);
}

inline Complex nothing() { return {Lanes{}, Lanes{}}; }

}  // namespace

void ShiftedSystems::take(const PenalisedSystem& system) {
  if (nodes_.empty()) take(system.bar());
  const Contacts& contacts = system.contacts();
  for (const std::size_t i : in_contact_) set_flags(i, flags_[i] & ~(tied | held));
  in_contact_.clear();
  const auto add = [this](std::size_t i, Flag flag) {
    set_flags(i, flags_[i] | flag);
    in_contact_.push_back(i);
  };
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (!contacts.closed(k)) continue;
    const std::size_t node = contacts[k].unknown, before = contacts[k].joint > 0 ? node - 1 : node;
    if (!contacts.held(node))
      add(before < middle_ ? before : node, tied);
    else
      for (std::size_t i = before; i <= node; ++i) add(i, held);
  }
  const std::size_t n = nodes_.size();
  for (unflagged_ = std::min(middle_, n - 1 - middle_); unflagged_ > 0; --unflagged_)
    if (flags_[unflagged_ - 1] | flags_[n - unflagged_]) break;
}

void ShiftedSystems::take(const BarSystem& bar) {
  bar.dynamic_stiffness(1.0, 0.0, 0.0, mass_);
  bar.dynamic_stiffness(0.0, 1.0, 0.0, damping_);
  bar.dynamic_stiffness(0.0, 0.0, 1.0, stiffness_);
  if (!bar.side()) stiffness_.one_sided.clear(), damping_.one_sided.clear();
  const std::size_t n = bar.size();
  nodes_.resize(n);
  in_contact_.reserve(bar.contacts().size());
  flag_rows(bar);
  find_alike();
  damping_ratio_.resize(static_cast<Eigen::Index>(n));
  stiffness_ratio_.resize(static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) set_flags(i, flags_[i]);
  if (const SideRows* side = bar.side()) return sum_rows_beside(bar, *side);
  sum_rows(stiffness_, bound_);
  sum_rows(damping_, dashed_);
}

// The sums of the side's rows apart, which are as small beside E/h as those of the inertia.
void ShiftedSystems::sum_rows_beside(const BarSystem& bar, const SideRows& side) {
  const std::size_t first = bar.unknowns().first_node(), n = bar.size();
  for (const bool drag : {false, true}) {
    BandedMatrix bare = drag ? damping_ : stiffness_;
    side.add_to(bare, first, drag ? -1.0 : 0.0, drag ? 0.0 : -1.0);
    std::vector<double>& sums = drag ? dashed_ : bound_;
    sum_rows(bare, sums);
    const auto coefficient = [&](std::size_t j) {
      return j < first || j - first >= n ? 0.0 : drag ? -side.drag(j) : -side.stiffness(j);
    };
    side.subtract(coefficient, first, n, sums);
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
  middle_ = middle_of(bar.inertia().matrix()).value();
  beyond_.resize(mass_.one_sided.size());
  flags_.assign(n, 0);
  rows_.clear();
  rows_.reserve(mass_.one_sided.size());
  for (const OneSidedRow& row : mass_.one_sided) {
    const bool right = row.row > middle_, ahead = row.leftwards == right;
    rows_.push_back({row.row, row.column(1), row.column(2), ahead});
    flags_[row.row] |= ahead ? amended | goes_ahead : amended | goes_back;
    const std::size_t inwards = right ? row.row - 1 : row.row + 1, outwards = right ? row.row + 1 : row.row - 1;
    flags_[ahead ? inwards : outwards] |= amended;
  }
}

void ShiftedSystems::find_alike() {
  const std::size_t n = nodes_.size(), both = std::min(middle_, n - 1 - middle_);
  alike_ = both;
  const auto same = [like = both - 1](const BandedMatrix& of, std::size_t i, std::size_t off) {
    return (of.diagonal[i] == of.diagonal[like]) & (of.off_diagonal[off] == of.off_diagonal[like]);
  };
  const auto alike = [&](std::size_t i, std::size_t off) {
    return same(mass_, i, off) & same(damping_, i, off) & same(stiffness_, i, off);
  };
  while (alike_ > 0 && alike(alike_ - 1, alike_ - 1) && alike(n - alike_, n - 1 - alike_)) --alike_;
}

void ShiftedSystems::set_flags(std::size_t i, int flags) {
  flags_[i] = static_cast<unsigned char>(flags);
  const double inertia = flags & held ? 0.0 : mass_.diagonal[i];
  damping_ratio_.data()[i] = inertia > 0.0 ? damping_.diagonal[i] / inertia : 0.0;
  stiffness_ratio_.data()[i] = inertia > 0.0 ? stiffness_.diagonal[i] / inertia : 0.0;
}

void ShiftedSystems::factorise(double h) {
  h_ = h;
  // Elasticity and damping, beside the inertia of the poles, which are some 10.
  const double largest = std::max(0.0, (h * damping_ratio_ + 0.1 * h * h * stiffness_ratio_).maxCoeff());
  rounding_ = 300.0 * std::numeric_limits<double>::epsilon() * (1.0 + 0.1 * largest);
  const Coefficients at = coefficients();
  // Pointers of its own: what is stored could change those of vectors, for all that the compiler knows.
  const Entries diagonal{mass_.diagonal.data(), damping_.diagonal.data(), stiffness_.diagonal.data()};
  const Entries beside{mass_.off_diagonal.data(), damping_.off_diagonal.data(), stiffness_.off_diagonal.data()};
  const bool skew = !mass_.skew.empty() || !stiffness_.skew.empty();
  Node* const nodes = nodes_.data();
  const unsigned char* const flags = flags_.data();
  const std::size_t n = nodes_.size(), middle = middle_;
  // Either end's elimination comes to node i, whose diagonal has lost that; `off` is the entry of it and the next one.
  const auto come = [=](std::size_t i, std::size_t off, const Complex& loss) __attribute__((always_inline)) {
    return Front{at(diagonal, i) - loss, at(beside, off), at(beside, off)};
  };
  // Takes node i out; gives what the diagonal of the next one loses.
  const auto take_out = [=](std::size_t i, const Front& front, const Complex& inverse) __attribute__((always_inline)) {
    Node& here = nodes[i];
    here.inverse_pivot = inverse;
    here.towards = front.upper * inverse;
    here.away = front.coupling * inverse;
    return here.away * front.upper;
  };
  const auto give_to_next = [=](std::size_t i, const Front& front) -> Complex {
    nodes[i].inverse_pivot = nothing();
    nodes[i].towards = nodes[i].away = {Lanes{} - 1.0, Lanes{}};
    return nothing() - front.pivot;
  };
  // By value: an address that is given away would keep both eliminations in memory.
  const auto pass = [&, at, flags ](std::size_t i, std::size_t off, Complex loss) __attribute__((noinline)) {
    Front front = come(i, off, loss);
    if (skew) {
      const auto of = [off](const BandedMatrix& matrix) { return matrix.skew.empty() ? 0.0 : matrix.skew[off]; };
      const Complex lean = (off == i ? 1.0 : -1.0) * at(of(mass_), of(damping_), of(stiffness_));
      front.upper = front.upper + lean;
      front.coupling = front.coupling - lean;
    }
    if (flags[i] & amended) amend(front, i, at);
    return flags[i] & tied ? give_to_next(i, front)
                           : take_out(i, front, flags[i] & held ? nothing() : reciprocal(front.pivot));
  };
  const std::size_t right_count = n - 1 - middle, both = std::min(middle, right_count);
  const std::size_t unflagged = skew ? both : unflagged_, alike = std::max(alike_, unflagged);
  Complex left = nothing(), right = nothing();
  std::size_t j = 0;
  for (; j < unflagged; ++j) {
    left = pass(j, j, left);
    right = pass(n - 1 - j, n - 2 - j, right);
  }
  const auto go_on = [=](std::size_t i, const Front& front) __attribute__((always_inline)) {
    return take_out(i, front, reciprocal(front.pivot));
  };
  for (; j < alike; ++j) {
    left = go_on(j, come(j, j, left));
    right = go_on(n - 1 - j, come(n - 1 - j, n - 2 - j, right));
  }
  const Complex own = j < both ? at(diagonal, j) : nothing(), next = j < both ? at(beside, j) : nothing();
  for (; j < both; ++j) {
    left = go_on(j, {own - left, next, next});
    right = go_on(n - 1 - j, {own - right, next, next});
  }
  for (; j < middle; ++j) left = pass(j, j, left);
  for (j = both; j < right_count; ++j) right = pass(n - 1 - j, n - 2 - j, right);
  nodes[middle].inverse_pivot = flags[middle] & held ? nothing() : reciprocal(at(diagonal, middle) - left - right);
}

// Adds one-sided rows to node i and its neighbours. A row that goes ahead, where the elimination goes, has an entry
// beyond the next node; of one that goes back the node before that is taken out.
void ShiftedSystems::amend(Front& front, std::size_t i, const Coefficients& at) {
  const bool of_inertia = damping_.one_sided.empty() && stiffness_.one_sided.empty();
  const auto row_entry = [&](std::size_t r, std::size_t k) -> Complex {
    const double m = mass_.one_sided[r].entries[k];
    if (of_inertia) return {at.of_mass.re * m, at.of_mass.im * m};
    const auto of = [&](const BandedMatrix& matrix) {
      return matrix.one_sided.empty() ? 0.0 : matrix.one_sided[r].entries[k];
    };
    return at(m, of(damping_), of(stiffness_));
  };
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const RowBeside& row = rows_[r];
    if (row.node == i) {
      front.pivot = front.pivot + row_entry(r, 0);
      if (row.ahead) front.upper = front.upper + row_entry(r, 1), beyond_[r] = row_entry(r, 2);
    } else if (row.next != i) {
      continue;
    } else if (row.ahead) {
      front.upper = front.upper - nodes_[row.node].away * beyond_[r];
      beyond_[r] = beyond_[r] * nodes_[row.node].inverse_pivot;
    } else {
      const Node& out = nodes_[row.beyond];
      front.coupling = front.coupling + row_entry(r, 1) - row_entry(r, 2) * out.towards;
      beyond_[r] = row_entry(r, 2) * out.inverse_pivot;
    }
  }
}

void ShiftedSystems::multiply_stiffness(std::span<const double> x, std::span<double> out) const {
  const std::size_t n = nodes_.size();
  if (!stiffness_.one_sided.empty() || !stiffness_.skew.empty()) return multiply_beside(x, out);
  // Pulls of the elements first, then their differences: several nodes at once.
  for (std::size_t i = 0; i + 1 < n; ++i) out[i] = stiffness_.off_diagonal[i] * (x[i + 1] - x[i]);
  out[n - 1] = 0.0;
  for (std::size_t i = n - 1; i > 0; --i) out[i] = bound_[i] * x[i] + (out[i] - out[i - 1]);
  out[0] += bound_[0] * x[0];
  for (const std::size_t i : in_contact_)
    if (is_held(i)) out[i] = 0.0;
}

void ShiftedSystems::multiply_beside(std::span<const double> x, std::span<double> out) const {
  const std::size_t n = nodes_.size();
  for (std::size_t i = 0; i < n; ++i) {
    out[i] = 0.0;
    if (is_held(i)) continue;
    out[i] = bound_[i] * x[i];
    if (i > 0) out[i] += stiffness_.below(i - 1) * (x[i - 1] - x[i]);
    if (i + 1 < n) out[i] += stiffness_.above(i) * (x[i + 1] - x[i]);
  }
  for (const OneSidedRow& row : stiffness_.one_sided)
    for (std::size_t k = 1; k < 3 && !is_held(row.row); ++k)
      out[row.row] += row.entries[k] * (x[row.column(k)] - x[row.row]);
}

// The right-hand side of node i less the share in its one-sided rows, back or ahead, of the node beyond the next one.
Complex ShiftedSystems::less_beyond(std::size_t i, Flag rows, Complex at, std::span<const Complex> x) const {
  for (std::size_t r = 0; r < rows_.size(); ++r)
    if (rows_[r].node == i && rows_[r].ahead == (rows == goes_ahead)) at = at - beyond_[r] * x[rows_[r].beyond];
  return at;
}

template <class RightSide>
void ShiftedSystems::substitute(const RightSide& right_side, std::span<Complex> of) const {
  const std::size_t n = nodes_.size(), middle = middle_;
  const Node* const nodes = nodes_.data();
  const unsigned char* const flags = flags_.data();
  Complex* const x = of.data();
  const std::size_t right_count = n - 1 - middle, both = std::min(middle, right_count), unflagged = unflagged_;
  Complex left = right_side(0), right = right_side(n - 1);
  x[0] = left;
  x[n - 1] = right;
  // From the node `before`, which is further out, to node j.
  const auto out = [=](std::size_t j, std::size_t before, const Complex& last) __attribute__((always_inline)) {
    return right_side(j) - nodes[before].away * last;
  };
  const auto out_flagged = [=, this](std::size_t j, std::size_t before, const Complex& last) {
    Complex at = out(j, before, last);
    if (flags[j] & goes_back) at = less_beyond(j, goes_back, at, of);
    return x[j] = at;
  };
  std::size_t j = 1;
  for (; j < unflagged; ++j) {
    left = out_flagged(j, j - 1, left);
    right = out_flagged(n - 1 - j, n - j, right);
  }
  for (; j < both; ++j) {
    x[j] = left = out(j, j - 1, left);
    x[n - 1 - j] = right = out(n - 1 - j, n - j, right);
  }
  for (std::size_t i = j; i < middle; ++i) left = out_flagged(i, i - 1, left);
  for (std::size_t i = j; i < right_count; ++i) right = out_flagged(n - 1 - i, n - i, right);
  left = right = x[middle] = nodes[middle].inverse_pivot *
                             (right_side(middle) - nodes[middle - 1].away * left - nodes[middle + 1].away * right);
  const auto in = [=](std::size_t i, const Complex& last) __attribute__((always_inline)) {
    return nodes[i].inverse_pivot * x[i] - nodes[i].towards * last;
  };
  const auto in_flagged = [=, this](std::size_t i, const Complex& last) {
    Complex at = in(i, last);
    if (flags[i] & goes_ahead) at = less_beyond(i, goes_ahead, at, of);
    return x[i] = at;
  };
  std::size_t i = middle, k = middle + 1;
  for (; i > both; --i) left = in_flagged(i - 1, left);
  for (; n - k > both; ++k) right = in_flagged(k, right);
  for (; i > unflagged; --i, ++k) {
    x[i - 1] = left = in(i - 1, left);
    x[k] = right = in(k, right);
  }
  for (; i > 0; --i, ++k) {
    left = in_flagged(i - 1, left);
    right = in_flagged(k, right);
  }
}

// Row i of right_side - D x.
Complex ShiftedSystems::residual(std::size_t i, const Complex& right_side, std::span<const Complex> x) const {
  if (is_held(i)) return nothing();
  const std::size_t n = nodes_.size();
  const Coefficients at = coefficients();
  const auto elastic = [&](double c, double k) -> Complex {
    return {at.of_stiffness.re * k + at.h * c, at.of_stiffness.im * k};
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
  return sum - at.of_mass * inertia;
}

void ShiftedSystems::solve(std::span<const double> force, std::span<const double> stiff_rate, bool loaded,
                           std::span<Complex> x) {
  const Formula& formula = Formula::get();
  const double h = h_;
  const Lanes re = -h * h * formula.inverse.re, im = -h * h * formula.inverse.im;
  // Numbers of its own: what is stored could change those of spans, for all that the compiler knows.
  const auto unloaded =
      [ re,
        im, h, rate = stiff_rate.data(), by = force.data() ](std::size_t i) __attribute__((always_inline))->Complex {
    return {re * rate[i] + h * by[i], im * rate[i]};
  };
  if (!refines_) {
    if (loaded)
      substitute([=](std::size_t i) { return unloaded(i) + x[i]; }, x);
    else
      substitute(unloaded, x);
    return;
  }
  const std::size_t n = nodes_.size();
  right_.resize(n);
  correction_.resize(n);
  for (std::size_t i = 0; i < n; ++i) right_[i] = loaded ? unloaded(i) + x[i] : unloaded(i);
  substitute([right = right_.data()](std::size_t i) { return right[i]; }, x);
  for (std::size_t i = 0; i < n; ++i) correction_[i] = residual(i, right_[i], x);
  substitute([rest = correction_.data()](std::size_t i) { return rest[i]; }, correction_);
  for (std::size_t i = 0; i < n; ++i) x[i] = x[i] + correction_[i];
}

}  // namespace viscobar::radau
