#include "integration/step_polynomial.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "integration/accounts/energy_flow.hpp"

namespace viscobar {

std::array<double, 6> relaxed_powers(double mu, double s) {
  std::array<double, 6> power{1.0}, integral{};
  for (std::size_t j = 1; j < 6; ++j) power[j] = power[j - 1] * s;
  const double x = mu * s;
  if (x > 6.0) {
    integral[0] = (1.0 - std::exp(-x)) / mu;
    for (std::size_t j = 1; j < 6; ++j) integral[j] = (power[j] - static_cast<double>(j) * integral[j - 1]) / mu;
    return integral;
  }
  double term = power[5] * s / 6.0, sum = term;
  for (int m = 1; std::abs(term) > 1e-17 * std::abs(sum); ++m) sum += term *= -x / (6.0 + m);
  integral[5] = sum;
  for (std::size_t j = 5; j > 0; --j) integral[j - 1] = (power[j] - mu * integral[j]) / static_cast<double>(j);
  return integral;
}

StepPolynomial::StepPolynomial(PenalisedSystem& system, const Layout& layout, std::span<Derivative* const> derivatives)
    : system_(system),
      layout_(layout),
      derivatives_(derivatives),
      begin_{0.0, std::vector<double>(layout.size), std::vector<double>(layout.nodes),
             std::vector<double>(layout.size - layout.first_derivative)},
      end_(begin_),
      relaxation_of_(layout.nodes, 0),
      inner_(layout.account() > 0 ? layout.size : 0) {
  unresolved_.reserve(system.contacts().size());
  relaxations_.reserve(system.contacts().size() + 2);
}

void StepPolynomial::begin_run(std::vector<std::size_t> sampled_entries) {
  entries_ = std::move(sampled_entries);
  sampled_.resize(entries_.size());
  selected_.resize(entries_.size());
  std::iota(selected_.begin(), selected_.end(), std::size_t{0});
}

void StepPolynomial::restart() {
  first_of_leg_ = true;
  relaxations_.clear();
  std::ranges::fill(relaxation_of_, std::size_t{0});
  for (const auto& row : relaxing_rows(system_.contacts())) relax(row, system_.load().at(row.unknown, end_.t));
  massless_ = relaxations_.size();
}

void StepPolynomial::relax(const RelaxingRow& row, double load) {
  relaxations_.push_back({row, load, {}});
  relaxation_of_[row.unknown] = relaxations_.size();
}

void StepPolynomial::complete() {
  defects_.clear();
  system_.complete_displacement(end_.t, layout_.u(end_.y));
  system_.complete_velocity(end_.t, layout_.u(end_.y), layout_.w(end_.y));
  forgotten_ = false;
  if (std::exchange(first_of_leg_, false)) forget_acceleration();
  if (system_.contacts().size() > 0) smooth_unresolved();
  for (Relaxation& relaxation : relaxations_) drive(relaxation);
  add_account(end_.t, end_.y);
}

bool StepPolynomial::spoils_acceleration(const PenalisedSystem& system, double length) {
  const Bar& bar = system.bar().bar();
  const double h = system.bar().elements().finest();
  return 12.0 * bar.viscosity / (bar.density * h * h) * length > 48.0;
}

// As a leg begins, a massless node may be far from where its row draws it. What that does to the others is over after a
// few times 1 / rate, but a_0 has it: where the step is much longer, a_0 is that of the quartic through the rest. So it
// is where a_0 is little more than what viscosity makes of an error.
void StepPolynomial::forget_acceleration() {
  constexpr double over = 6.0;
  const std::size_t n = layout_.nodes;
  const double h = length();
  if (!spoils_acceleration(system_, h) &&
      std::ranges::none_of(relaxations_, [&](const Relaxation& r) { return r.row.rate * h > over; }))
    return;
  forgotten_ = true;
  for (std::size_t i = system_.bar().inertia().massive_begin(); i < system_.bar().inertia().massive_end(); ++i)
    begin_.a[i] = end_.a[i] + 12.0 / (h * h) * (increment(i) - 0.5 * h * (begin_.y[n + i] + end_.y[n + i]));
}

bool StepPolynomial::passes_over(std::size_t contact) {
  if (!system_.contacts().closed(contact) || !system_.contacts()[contact].is_passed_over(length())) return false;
  const double turns = system_.contacts()[contact].rate * length();
  const double deepest = std::max(std::abs(system_.contacts().clearance(contact, layout_.u(begin_.y))),
                                  std::abs(system_.contacts().clearance(contact, layout_.u(end_.y))));
  return 2.0 * deepest <= tolerance_ * turns * turns * turns;
}

void StepPolynomial::smooth_unresolved() {
  unresolved_.clear();
  for (; relaxations_.size() > massless_; relaxations_.pop_back()) relaxation_of_[relaxations_.back().row.unknown] = 0;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    if (!passes_over(c)) continue;
    const std::size_t i = system_.contacts()[c].unknown;
    const std::span ends = std::span(unresolved_).first(std::min<std::size_t>(unresolved_.size(), 2));
    if (std::ranges::find(ends, i) != ends.end()) continue;  // under a span obstacle, too
    unresolved_.push_back(i);
    relax(resting_row(system_.contacts(), c), system_.load().at(i, begin_.t));
  }
  if (unresolved_.empty()) return;
  rest_unresolved(begin_.a);
  rest_unresolved(end_.a);
}

// Where a of those nodes becomes 0, a change by c, that of the others changes by x, M_rr x = -M_rc c.
void StepPolynomial::rest_unresolved(std::span<double> a) {
  const BandedMatrix& inertia = system_.bar().inertia().matrix();
  if (inertia.off_diagonal.empty()) {
    for (const std::size_t i : unresolved_) a[i] = 0.0;
    return;
  }
  const std::size_t n = layout_.nodes;
  if (replaced_ != unresolved_) {
    BandedMatrix beside = inertia;
    for (std::size_t i = 0; i < n; ++i)
      if (beside.diagonal[i] == 0.0) beside.diagonal[i] = 1.0;  // massless
    for (const std::size_t i : unresolved_) {
      if (i > 0) beside.uncouple(i - 1);
      if (i + 1 < n) beside.uncouple(i);
    }
    const auto rests = [&](std::size_t i) { return std::ranges::find(unresolved_, i) != unresolved_.end(); };
    beside.uncouple_one_sided(rests);
    beside_.factorise(beside);
    replaced_ = unresolved_;
  }
  change_.assign(n, 0.0);
  for (const std::size_t i : unresolved_) {
    if (i > 0) change_[i - 1] += inertia.above(i - 1) * a[i];
    if (i + 1 < n) change_[i + 1] += inertia.below(i) * a[i];
    for (const OneSidedRow& one : inertia.one_sided)
      for (std::size_t k = 0; k < 3; ++k)
        if (one.column(k) == i) change_[one.row] += one.entries[k] * a[i];
  }
  for (const std::size_t i : unresolved_) change_[i] = 0.0;
  beside_.solve(change_);
  for (std::size_t i = 0; i < n; ++i) a[i] += change_[i];
  for (const std::size_t i : unresolved_) a[i] = 0.0;
}

void StepPolynomial::drive(Relaxation& relaxation) {
  const auto& row = relaxation.row;
  const std::size_t n = layout_.nodes;
  const double h = length();
  relaxation.drive = {row.constant + row.load_share * relaxation.load};
  for (std::size_t k = 0; k < row.count; ++k) {
    const auto& next = row.neighbours[k];
    const std::size_t i = next.unknown;
    const double w0 = h * begin_.y[n + i], w1 = h * end_.y[n + i], a0 = h * h * begin_.a[i], a1 = h * h * end_.a[i];
    const double d = defect(i);
    const std::array<double, 6> u = {begin_.y[i],
                                     w0,
                                     0.5 * a0,
                                     w1 - w0 - (2.0 * a0 + a1) / 3.0 + 10.0 * d,
                                     0.5 * (w0 - w1) + 0.25 * (a0 + a1) - 15.0 * d,
                                     6.0 * d};
    for (std::size_t j = 0; j < 6; ++j) {
      const double up = static_cast<double>(j + 1), twice = up * static_cast<double>(j + 2);
      relaxation.drive[j] += next.u_share * u[j] + (j < 5 ? next.w_share * up * u[j + 1] / h : 0.0) -
                             (j < 4 ? next.a_share * twice * u[j + 2] / (h * h) : 0.0);
    }
  }
  if (system_.load().varies()) drive_by_load(relaxation);
  for (std::size_t j = 0; j < 4; ++j)
    relaxation.drive[j] -= row.inertia / (h * h) * static_cast<double>((j + 1) * (j + 2)) * relaxation.drive[j + 2];
}

void StepPolynomial::drive_by_load(Relaxation& relaxation) {
  const auto& row = relaxation.row;
  std::array<double, 5> loads{relaxation.load};
  for (std::size_t j = 1; j < 5; ++j)
    loads[j] = system_.load().at(row.unknown, j == 4 ? end_.t : begin_.t + 0.25 * static_cast<double>(j) * length());
  relaxation.load = loads[4];
  const std::array<double, 5> power = powers_through(loads);
  for (std::size_t j = 1; j < 5; ++j) relaxation.drive[j] += row.load_share * power[j];
}

StepPolynomial::Weights StepPolynomial::weights(double s, int derivative) {
  const double r = 1.0 - s, s2 = s * s, s3 = s2 * s;
  switch (derivative) {
    case 0:
      return {s - s3 + 0.5 * s2 * s2, s3 - 0.5 * s2 * s2, s2 * (0.5 - s * (2.0 / 3.0) + 0.25 * s2),
              s3 * (0.25 * s - 1.0 / 3.0), s3 * (10.0 - 15.0 * s + 6.0 * s2)};
    case 1: return {r * r * (1.0 + 2.0 * s), s2 * (3.0 - 2.0 * s), s * r * r, -s2 * r, 30.0 * s2 * r * r};
    default:
      return {-6.0 * s * r, 6.0 * s * r, r * (1.0 - 3.0 * s), s * (3.0 * s - 2.0), 60.0 * s * r * (1.0 - 2.0 * s)};
  }
}

// D / h would be noise where D is no more than the rounding of u, as in the short steps after a contact change.
double StepPolynomial::defect(std::size_t i) const {
  const std::size_t n = layout_.nodes;
  const double h = length();
  const double missing =
      increment(i) - 0.5 * h * (begin_.y[n + i] + end_.y[n + i]) + h * h / 12.0 * (end_.a[i] - begin_.a[i]);
  if (known_) return missing;
  const double rounding = 2.0 * std::numeric_limits<double>::epsilon() * (std::abs(begin_.y[i]) + std::abs(end_.y[i]));
  return std::abs(missing) > rounding ? missing : 0.0;
}

double StepPolynomial::massive(std::size_t i, const Weights& weights) const {
  const std::size_t n = layout_.nodes;
  const double h = length();
  return h * (weights.w0 * begin_.y[n + i] + weights.w1 * end_.y[n + i] +
              h * (weights.a0 * begin_.a[i] + weights.a1 * end_.a[i])) +
         weights.defect * defect(i);
}

double StepPolynomial::relaxed(const Relaxation& relaxation, double s) const {
  const double h = length(), mu = relaxation.row.rate * h;
  const std::array<double, 6> powers = relaxed_powers(mu, s);
  double sum = 0.0;
  for (std::size_t j = 0; j < 6; ++j) sum += relaxation.drive[j] * powers[j];
  return std::exp(-mu * s) * begin_.y[relaxation.row.unknown] + h * sum;
}

double StepPolynomial::relaxed_rate(const Relaxation& relaxation, double s, double u) {
  double rate = 0.0;
  for (std::size_t j = 6; j-- > 0;) rate = rate * s + relaxation.drive[j];
  return rate - relaxation.row.rate * u;
}

// massive() of all nodes, defects_ being known.
auto StepPolynomial::all_massive(const Weights& of) const {
  const std::size_t n = layout_.nodes;
  const double h = length();
  const auto values = [n](const std::vector<double>& all, std::size_t first = 0) {
    return Eigen::Map<const Eigen::ArrayXd>(all.data() + first, static_cast<Eigen::Index>(n));
  };
  const auto w0 = values(begin_.y, n), w1 = values(end_.y, n), a0 = values(begin_.a), a1 = values(end_.a),
             d = values(defects_);
  return h * (of.w0 * w0 + of.w1 * w1 + h * (of.a0 * a0 + of.a1 * a1)) + of.defect * d;
}

void StepPolynomial::motion_at(double t, std::span<double> y) {
  const std::size_t n = layout_.nodes;
  const double h = length(), s = (t - begin_.t) / h;
  if (defects_.empty()) {
    defects_.resize(n);
    for (std::size_t i = 0; i < n; ++i) defects_[i] = defect(i);
  }
  const auto out = [&](std::size_t first) {
    return Eigen::Map<Eigen::ArrayXd>(y.data() + first, static_cast<Eigen::Index>(n));
  };
  out(0) = Eigen::Map<const Eigen::ArrayXd>(begin_.y.data(), static_cast<Eigen::Index>(n)) + all_massive(weights(s, 0));
  out(n) = all_massive(weights(s, 1)) / h;
  for (std::size_t k = 0; k < relaxations_.size(); ++k) {
    const std::size_t i = relaxations_[k].row.unknown;
    y[i] = relaxed(relaxations_[k], s);
    if (k >= massless_) y[n + i] = relaxed_rate(relaxations_[k], s, y[i]);
  }
  system_.complete_displacement(t, layout_.u(y));
}

void StepPolynomial::at(double t, std::span<double> y) {
  if (t == end_.t || t == begin_.t) {
    std::ranges::copy(t == end_.t ? end_.y : begin_.y, y.begin());
    return;
  }
  motion_at(t, y);
  add_account(t, y);
  if (layout_.derivatives > 0) derivatives_at(t, y);
}

void StepPolynomial::add_account(double until, std::span<double> y) {
  if (inner_.empty()) return;
  const auto accounts = static_cast<std::ptrdiff_t>(2 * layout_.nodes);
  std::copy_n(begin_.y.begin() + accounts, layout_.account(), y.begin() + accounts);
  add_energy_flow<3>(
      system_, layout_, begin_.t, until, [&](double t, std::span<double> inner) { motion_at(t, inner); },
      [&](double t) {
        const std::size_t n = layout_.nodes;
        const double h = length(), s = (t - begin_.t) / h;
        const Weights second = weights(s, 2);
        accelerations_.resize(system_.bar().inertia().row_values());
        const auto at = [&](std::size_t i) { return value(i, s, 2, second); };
        if (accelerations_.size() != n) {
          row_values(n, at, accelerations_);
        } else {
          Eigen::Map<Eigen::ArrayXd>(accelerations_.data(), static_cast<Eigen::Index>(n)) =
              all_massive(second) / (h * h);
          for (const Relaxation& one : relaxations_) accelerations_[one.row.unknown] = at(one.row.unknown);
        }
        return std::span<const double>(accelerations_);
      },
      inner_, y.subspan(2 * layout_.nodes, layout_.account()));
}

double StepPolynomial::value(std::size_t unknown, double s, int derivative) const {
  return value(unknown, s, derivative, weights(s, derivative));
}

double StepPolynomial::value(std::size_t unknown, double s, int derivative, const Weights& weights) const {
  if (const std::size_t place = relaxation_of_[unknown]) {
    const Relaxation& relaxation = relaxations_[place - 1];
    const double u = relaxed(relaxation, s);
    if (derivative == 0) return u;
    const double w = relaxed_rate(relaxation, s, u);
    if (derivative == 1) return w;
    double drive = 0.0;
    for (std::size_t j = 6; j-- > 1;) drive = drive * s + static_cast<double>(j) * relaxation.drive[j];
    return drive / length() - relaxation.row.rate * w;
  }
  const double change = massive(unknown, weights), h = length();
  return derivative == 0 ? begin_.y[unknown] + change : change / (derivative == 1 ? h : h * h);
}

void StepPolynomial::sample(double begin, double end, std::span<const std::size_t> entries,
                            std::span<PointValues> out) const {
  const std::size_t n = layout_.nodes;
  const double h = length();
  std::array<double, degree + 1> parts;
  std::array<std::array<Weights, degree + 1>, 2> at;
  for (std::size_t j = 0; j <= degree; ++j) {
    parts[j] = (point_of(begin, end, degree, j) - begin_.t) / h;
    at[0][j] = weights(parts[j], 0), at[1][j] = weights(parts[j], 1);
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::size_t rate = entries[i] < n ? 0 : 1, node = entries[i] - rate * n;
    const bool relaxes = relaxation_of_[node] > 0;
    const double w0 = begin_.y[n + node], w1 = end_.y[n + node], a0 = h * begin_.a[node], a1 = h * end_.a[node];
    const double start = rate ? 0.0 : begin_.y[node], missing = defect(node) / h, unit = rate ? 1.0 : h;
    for (std::size_t j = 0; j <= degree; ++j) {
      const Weights& of = at[rate][j];
      out[i][j] = relaxes ? value(node, parts[j], static_cast<int>(rate))
                          : start + unit * (of.w0 * w0 + of.w1 * w1 + of.a0 * a0 + of.a1 * a1 + of.defect * missing);
    }
  }
}

void StepPolynomial::hull(std::span<double> lowest, std::span<double> highest, std::span<double> last) const {
  const std::size_t n = layout_.nodes;
  const double h = length(), infinity = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < entries_.size(); ++k) {
    const std::size_t i = entries_[k];
    if (i >= n || relaxation_of_[i] > 0) {
      lowest[k] = -infinity, highest[k] = infinity;
      continue;
    }
    const double u0 = begin_.y[i], u1 = end_.y[i], w0 = 0.2 * h * begin_.y[n + i], w1 = 0.2 * h * end_.y[n + i];
    const double a0 = 0.05 * h * h * begin_.a[i], a1 = 0.05 * h * h * end_.a[i];
    const auto [least, most] = std::minmax({u0, u0 + w0, u0 + 2.0 * w0 + a0, u1 - 2.0 * w1 + a1, u1 - w1, u1});
    lowest[k] = least, highest[k] = most, last[k] = u1;
  }
}

std::span<const double> StepPolynomial::sample(double t, int derivative) {
  const std::size_t n = layout_.nodes;
  const double s = (t - begin_.t) / length();
  const Weights of_u = weights(s, derivative), of_w = weights(s, derivative + 1);
  for (const std::size_t k : selected_) {
    const std::size_t entry = entries_[k];
    sampled_[k] = entry < n ? value(entry, s, derivative, of_u) : value(entry - n, s, derivative + 1, of_w);
  }
  return sampled_;
}

// The derivatives by parameters.

std::array<double, 2> StepPolynomial::derivative_at(std::size_t k, std::size_t i, double s) const {
  const std::size_t n = layout_.nodes, rate = k * layout_.block + n + i;
  const double h = length();
  const auto y0 = layout_.derivative(std::span(begin_.y), k), y1 = layout_.derivative(std::span(end_.y), k);
  const double half = 0.5 * h * (y0[n + i] + y1[n + i]), rise = y1[i] - y0[i], a1 = end_.derivative_rates[rate];
  const double a0 = forgotten_ ? a1 + 12.0 / (h * h) * (rise - half) : begin_.derivative_rates[rate];
  const double missing = rise - half + h * h / 12.0 * (a1 - a0);
  const auto at = [&](const Weights& weight) {
    return h * (weight.w0 * y0[n + i] + weight.w1 * y1[n + i] + h * (weight.a0 * a0 + weight.a1 * a1)) +
           weight.defect * missing;
  };
  return {y0[i] + at(weights(s, 0)), at(weights(s, 1)) / h};
}

double StepPolynomial::relaxed_derivative(const Relaxation& relaxation, std::size_t k, double s) const {
  constexpr std::size_t points = 6;
  Derivative& derivative = *derivatives_[k];
  const std::size_t node = relaxation.row.unknown, next = relaxation.row.neighbours[0].unknown;
  for (const RelaxingRow& row : relaxing_rows(derivative.motion().contacts())) {
    if (row.unknown != node) continue;
    const double h = length();
    std::array<double, points> drive{};
    for (std::size_t j = 0; j < points; ++j) {
      const double at = static_cast<double>(j) / (points - 1), t = begin_.t + at * h;
      const auto [of_next, rate_of_next] = derivative_at(k, next, at);
      const double force =
          derivative.motion().load().alone(node, t) +
          derivative.drive_row(node, t, value(node, at, 0), value(next, at, 0), value(node, at, 1), value(next, at, 1));
      drive[j] = row.constant + row.neighbours[0].u_share * of_next + row.neighbours[0].w_share * rate_of_next +
                 row.load_share * force;
    }
    drive = powers_through(drive);
    const std::array<double, 6> powers = relaxed_powers(row.rate * h, s);
    double sum = 0.0;
    for (std::size_t p = 0; p < points; ++p) sum += drive[p] * powers[p];
    return std::exp(-row.rate * h * s) * layout_.derivative(std::span(begin_.y), k)[node] + h * sum;
  }
  return derivative_at(k, node, s)[0];
}

void StepPolynomial::derivatives_at(double t, std::span<double> y) const {
  const std::size_t n = layout_.nodes;
  const double h = length(), s = (t - begin_.t) / h, back = 1.0 - s;
  for (std::size_t k = 0; k < layout_.derivatives; ++k) {
    const auto y0 = layout_.derivative(std::span(begin_.y), k), y1 = layout_.derivative(std::span(end_.y), k);
    const double *r0 = begin_.derivative_rates.data() + k * layout_.block,
                 *r1 = end_.derivative_rates.data() + k * layout_.block;
    const auto out = layout_.derivative(y, k);
    const auto cubic = [&](std::size_t i) {
      return y0[i] + s * s * (3.0 - 2.0 * s) * (y1[i] - y0[i]) + h * s * back * (back * r0[i] - s * r1[i]);
    };
    for (std::size_t i = 0; i < n; ++i) {
      const auto [displacement, velocity] = derivative_at(k, i, s);
      out[i] = displacement, out[n + i] = velocity;
    }
    for (std::size_t r = 0; r < relaxations_.size(); ++r) {
      const std::size_t i = relaxations_[r].row.unknown;
      out[i] = r < massless_ ? relaxed_derivative(relaxations_[r], k, s) : cubic(i);
      out[n + i] = y0[n + i] + s * (y1[n + i] - y0[n + i]);
    }
    for (std::size_t i = 2 * n; i < layout_.block; ++i) out[i] = cubic(i);
  }
}

}  // namespace viscobar
