#include "integration/radau/step_derivatives.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar::radau {

namespace {

void add(Complex& to, const Complex& share, double times) {
  to.re += share.re * times;
  to.im += share.im * times;
}

}  // namespace

StepDerivatives::StepDerivatives(PenalisedSystem& system, const Layout& layout,
                                 std::span<Derivative* const> derivatives)
    : system_(system),
      layout_(layout),
      derivatives_(derivatives),
      force_(layout.nodes),
      rates_(layout.block - 2 * layout.nodes) {
  const std::size_t n = layout.nodes;
  if (layout.left) ends_.push_back(0);
  if (layout.right) ends_.push_back(n - 1);
  parts_.resize(derivatives.size(), {std::vector<double>(n),
                                     std::vector<double>(n),
                                     rates_,
                                     std::vector<Complex>(n),
                                     std::vector<Complex>(rates_.size()),
                                     {}});
  for (std::size_t k = 0; k < parts_.size(); ++k)
    if (derivatives[k]->load_varies()) parts_[k].load_tail.resize(n);
}

void StepDerivatives::multiply(const BandedMatrix& inertia, std::span<const Complex> x, std::vector<Complex>& out) {
  const std::size_t n = x.size();
  if (inertia.off_diagonal.empty()) {
    for (std::size_t i = 0; i < n; ++i) out[i] = inertia.diagonal[i] * x[i];
    return;
  }
  out[0] = inertia.diagonal[0] * x[0] + inertia.above(0) * x[1];
  for (std::size_t i = 1; i + 1 < n; ++i)
    out[i] = inertia.below(i - 1) * x[i - 1] + inertia.diagonal[i] * x[i] + inertia.above(i) * x[i + 1];
  out[n - 1] = inertia.below(n - 2) * x[n - 2] + inertia.diagonal[n - 1] * x[n - 1];
  for (const OneSidedRow& one : inertia.one_sided)
    for (std::size_t k = 0; k < 3; ++k) out[one.row] = out[one.row] + one.entries[k] * x[one.column(k)];
}

void StepDerivatives::impulse_rates(Derivative& derivative, const Moment& at, std::span<const double> s,
                                    std::vector<double>& rates) {
  for (std::size_t e = 0; e < ends_.size(); ++e) rates[e] = derivative.momentum_loss(ends_[e], at, s);
}

void StepDerivatives::evaluate(ShiftedSystems& systems, double t, std::span<double> y) {
  const std::size_t n = layout_.nodes;
  begin_ = {t, layout_.u(y), layout_.w(y), {}};
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    Part& part = parts_[k];
    Derivative& derivative = *derivatives_[k];
    derivative.drive(begin_);
    const std::span<double> block = layout_.derivative(y, k), u = block.first(n), w = block.subspan(n, n);
    derivative.motion().complete_velocity(t, u, w);
    derivative.motion().force(t, u, w, part.force);
    systems.multiply_stiffness(w, part.stiff_rate);
    const auto of_w = system_.bar().unknowns().at_nodes(begin_.w);
    const auto opposed = [&](std::size_t j) { return -of_w(j); };
    derivative.matrices().elastic().subtract(opposed, part.stiff_rate);
    for (const Support& support : derivative.supports())
      part.stiff_rate[support.unknown] += support.stiffness * begin_.w[support.unknown];
    for (const SideRows& side : derivative.sides())
      side.subtract([&](std::size_t j) { return side.stiffness(j) * opposed(j); },
                    system_.bar().unknowns().first_node(), n, part.stiff_rate);
    impulse_rates(derivative, begin_, u, part.impulse_rates);
  }
}

// x = -(zeta M' + h C' + h^2 / zeta K') X; whether that is anything.
bool StepDerivatives::drive(std::size_t k, std::span<const Complex> motion) {
  const Formula& formula = Formula::get();
  const Derivative& derivative = *derivatives_[k];
  const MatrixRates& matrices = derivative.matrices();
  if (!matrices.any() && derivative.supports().empty() && derivative.sides().empty()) return false;
  std::vector<Complex>& x = parts_[k].x;
  const std::size_t n = layout_.nodes, first = system_.bar().unknowns().first_node();
  const auto elastic = [&](double dashpot, double stiffness) {
    return Complex{h_ * dashpot + h_ * h_ * stiffness * formula.inverse.re, h_ * h_ * stiffness * formula.inverse.im};
  };
  const auto times = [&](const Complex& factor) {
    return [&, factor](std::size_t j) { return j < first || j - first >= n ? Complex{} : factor * motion[j - first]; };
  };
  std::ranges::fill(x, Complex{});
  if (matrices.inertial()) {
    multiply(matrices.inertia(), motion, x);
    for (Complex& one : x) one = -1.0 * formula.poles * one;
  }
  matrices.elastic().subtract(times(elastic(0.0, 1.0)), x);
  matrices.viscous().subtract(times(elastic(1.0, 0.0)), x);
  for (const auto& [unknown, stiffness, dashpot, mass] : derivative.supports())
    x[unknown] = x[unknown] - (elastic(dashpot, stiffness) + mass * formula.poles) * motion[unknown];
  for (const SideRows& side : derivative.sides())
    side.subtract([&](std::size_t j) { return times(elastic(side.drag(j), side.stiffness(j)))(j); }, first, n, x);
  return true;
}

// Change of the load over the step, for a motion that stands still.
void StepDerivatives::gather_load(std::size_t k, const Step& step, std::span<const double> begin, bool driven) {
  const Formula& formula = Formula::get();
  const std::size_t n = layout_.nodes;
  Part& part = parts_[k];
  Derivative& derivative = *derivatives_[k];
  const std::span<const double> block = layout_.derivative(begin, k);
  if (!driven) std::ranges::fill(part.x, Complex{});
  Moment at = begin_;
  for (std::size_t m = 0; m < stages; ++m) {
    at.t = m + 1 == stages ? step.reached : step.t + formula.nodes[m] * h_;
    if (m == 0 || system_.bar().frame().moving()) derivative.drive(at);  // others have driven it since
    derivative.motion().force(at.t, block.first(n), block.subspan(n, n), force_);
    const Complex share = h_ * formula.of_load[m];
    for (std::size_t i = 0; i < n; ++i) {
      const double change = force_[i] - part.force[i];
      add(part.x[i], share, change);
      part.load_tail.add(m, i, change);
    }
    impulse_rates(derivative, at, block.first(n), rates_);
    for (std::size_t e = 0; e < rates_.size(); ++e) add(part.impulses[e], share, rates_[e] - part.impulse_rates[e]);
  }
}

// Elastic impulses are linear in the change of u, whose image is h (w + X) / zeta.
void StepDerivatives::add_elastic_impulses(std::size_t k, std::span<const double> begin,
                                           std::span<const Complex> motion) {
  const std::size_t n = layout_.nodes;
  const auto image = [&](double rate, Complex x) {
    x.re += rate;
    return h_ * (Formula::get().inverse * x);
  };
  const double *w = begin.data() + n, *q = layout_.derivative(begin, k).data() + n;
  for (std::size_t e = 0; e < ends_.size(); ++e) {
    const Derivative& of = *derivatives_[k];
    const std::size_t end = ends_[e];
    const EndRows rows = end_rows(system_.contacts(), end);
    const std::size_t last = rows.last, beside = end == 0 ? last + 1 : last - 1;
    const std::vector<Complex>& x = parts_[k].x;
    const Complex u = image(w[end], motion[end]), s = image(q[end], x[end]);
    const Complex u_stretch = image(w[last], motion[last]) - image(w[beside], motion[beside]);
    const Complex s_stretch = image(q[last], x[last]) - image(q[beside], x[beside]);
    Complex& impulse = parts_[k].impulses[e];
    for (std::size_t l = 0; l < lanes; ++l) {
      impulse.re[l] += h_ * of.elastic_row(end, rows, u.re[l], u_stretch.re[l], s.re[l], s_stretch.re[l]);
      impulse.im[l] += h_ * of.elastic_row(end, rows, u.im[l], u_stretch.im[l], s.im[l], s_stretch.im[l]);
      if (!system_.bar().side()) continue;
      const auto part_of = [&](const double* rates, std::span<const Complex> changes, Lanes Complex::*part) {
        return [&, rates, changes, part](std::size_t j) {
          const std::size_t i = j - system_.bar().unknowns().first_node();
          return i < n ? (image(rates[i], changes[i]).*part)[l] : 0.0;
        };
      };
      for (Lanes Complex::*part : {&Complex::re, &Complex::im})
        (impulse.*part)[l] += h_ * of.side_row(end, rows, part_of(w, motion, part), part_of(q, x, part));
    }
  }
}

double StepDerivatives::attempt(ShiftedSystems& systems, const Step& step, std::span<const double> begin,
                                std::span<const Complex> motion, std::span<const double> weights, std::span<double> end,
                                Statistics& statistics) {
  h_ = step.h;
  const std::size_t n = layout_.nodes;
  double largest = 0.0;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    Part& part = parts_[k];
    for (std::size_t e = 0; e < ends_.size(); ++e) part.impulses[e] = {Lanes{} + h_ * part.impulse_rates[e], Lanes{}};
    bool driven = drive(k, motion);
    const auto weight = layout_.derivative(weights, k);
    if (derivatives_[k]->load_varies()) {
      gather_load(k, step, begin, driven);
      driven = true;
      largest = std::max(largest, part.load_tail.error(system_.bar(), h_, weight[0],
                                                       weight[n + system_.bar().inertia().massive_begin()]));
    }
    systems.solve(part.force, part.stiff_rate, driven, part.x);
    statistics.linear_solves += lanes;
    add_elastic_impulses(k, begin, motion);
    largest = std::max(largest, move(k, layout_.derivative(begin, k), weight, layout_.derivative(end, k)));
  }
  return largest;
}

// The error of the step.
double StepDerivatives::move(std::size_t k, std::span<const double> begin, std::span<const double> weights,
                             std::span<double> end) const {
  const Inertia& inertia = system_.bar().inertia();
  const Moved moved = move_nodes(h_, parts_[k].x, {inertia.massive_begin(), inertia.massive_end()}, begin, end);
  impulses_at(k, 1.0, begin, end);
  return std::max(moved.rate_error * weights[layout_.nodes + inertia.massive_begin()], moved.way_error * weights[0]);
}

void StepDerivatives::impulses_at(std::size_t k, double theta, std::span<const double> before,
                                  std::span<double> block) const {
  const Formula& formula = Formula::get();
  const Parts weights = formula.weights_over_pole(formula.weights(theta, 0));
  for (std::size_t e = 0; e < ends_.size(); ++e)
    block[2 * layout_.nodes + e] = before[2 * layout_.nodes + e] + combined(weights, parts_[k].impulses[e]);
}

void StepDerivatives::blocks_at(double theta, std::span<const double> begin, std::span<double> y) const {
  const Formula& formula = Formula::get();
  const Parts w = formula.weights(theta, 0), u = formula.weights_over_pole(w);
  std::array<Eigen::Array2d, parts> columns;
  for (std::size_t l = 0; l < parts; ++l) columns[l] = {w[l], h_ * u[l]};
  const std::size_t n = layout_.nodes;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const auto before = layout_.derivative(begin, k);
    const std::span<double> block = layout_.derivative(y, k);
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Array2d sum = combined(columns, parts_[k].x[i]);
      block[n + i] = before[n + i] + sum[0];
      block[i] = before[i] + (theta * h_ * before[n + i] + sum[1]);
    }
    impulses_at(k, theta, before, block);
  }
}

}  // namespace viscobar::radau
