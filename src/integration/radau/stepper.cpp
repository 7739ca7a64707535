#include "integration/radau/stepper.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "integration/accounts/energy_flow.hpp"
#include "integration/error_weights.hpp"
#include "integration/radau/gauss_powers.hpp"
#include "integration/radau/load_tail.hpp"
#include "integration/radau/shifted_systems.hpp"
#include "integration/radau/step_derivatives.hpp"
#include "integration/radau/step_powers.hpp"
#include "run/step_failure.hpp"

namespace viscobar::radau {

namespace {

constexpr double safety = 0.85, largest_growth = 8.0, largest_cut = 0.1;
constexpr double worth_a_factor = 1.25;    // growth of the step, in which a new factor pays
constexpr double next_after_impact = 3.0;  // of the first step after the impact before, that of the next one

// A step of 1e8 ways of a wave through the bar leaves its matrix no digit of the inertia.
double farthest(const PenalisedSystem& system) {
  const Bar& bar = system.bar().bar();
  return 1e6 * bar.length * bar.slowness();
}

// Parts of a step, of whole vectors.
const Samples& points_of_step() {
  static const Samples parts_of_step = Samples::LinSpaced(0.0, (stages + lanes - 1.0) / stages);
  return parts_of_step;
}

class Stepper final : public LegStepper {
 public:
  Stepper(const StepperParts& run, const Tolerance& tolerance)
      : system_(run.system),
        layout_(run.layout),
        statistics_(run.statistics),
        weights_(run.system, run.layout, tolerance, run.times.back(), one_step_accumulation, run.derivatives),
        longest_(std::min(longest_step(run.system, run.times.back() - run.times.front()), farthest(run.system))),
        step_(run.times.back() - run.times.front()),
        begin_y_(layout_.size),
        end_y_(layout_.size),
        force_(layout_.nodes),
        stiff_rate_(layout_.nodes),
        x_(layout_.nodes),
        inner_(layout_.account() > 0 ? layout_.size : 0) {
    if (system_.load().varies()) load_change_.resize(layout_.nodes), load_tail_.resize(layout_.nodes);
    if (!run.derivatives.empty()) {
      derivatives_.emplace(system_, layout_, run.derivatives);
      weight_.resize(layout_.size);
    }
    inner_contacts_ =
        std::ranges::any_of(system_.bar().contacts(), [](const Contact& contact) { return !contact.at_end(); });
  }

  void begin_run(std::vector<std::size_t> sampled_entries) override {
    entries_ = std::move(sampled_entries);
    sampled_.resize(entries_.size());
    selected_.reserve(entries_.size());
    for (auto& points : points_) points.resize(entries_.size());
  }

  void restart(double t, double stop, std::span<const double> y) override {
    weights_.tighten(statistics_.events);
    stop_ = stop;
    end_t_ = t;
    std::ranges::copy(y, end_y_.begin());
    const std::size_t closed_before = std::exchange(closed_, closed_contacts());
    stirred_ = !taken_ || closed_ > closed_before;
    if (stirred_) step_ = std::min(step_, next_after_impact * stirred_step_);
    if (taken_ != system_.contacts().revision()) {
      systems_.take(system_);
      taken_ = system_.contacts().revision();
      factorised_.reset();
    }
    if (derivatives_) derivatives_->evaluate(systems_, end_t_, end_y_);
    last_length_ = 0.0;
  }

  double advance() override {
    evaluate();
    std::swap(begin_y_, end_y_);
    begin_t_ = end_t_;
    notice(begin_y_);
    for (;;) {
      const double h = next_length();
      const double error = attempt(h);
      if (!std::isfinite(error)) throw not_finite();
      if (error <= 1.0) {
        if (std::exchange(stirred_, false) && h < stop_ - begin_t_) stirred_step_ = h;
        grow(h, error);
        break;
      }
      // Where modes pass that the step does not resolve, the error falls slower than by h^8.
      step_ = h * std::clamp(safety * std::cbrt(1.0 / error), largest_cut, safety);
      if (begin_t_ + step_ * 0x1p-4 == begin_t_)
        throw StepFailure(Failure::accuracy, "no step, however short, keeps the tolerance");
    }
    finish();
    return end_t_;
  }

  std::size_t order() const override { return stages; }
  ErrorWeights& weights() override { return weights_; }
  std::span<const double> account() const override {
    return std::span(end_y_).subspan(2 * layout_.nodes, layout_.account());
  }

  void changes_at(std::span<const double> y) override { notice(y); }

  void interpolate(double t, std::span<double> y) override {
    if (t == end_t_ || t == begin_t_) return void(std::ranges::copy(t == end_t_ ? end_y_ : begin_y_, y.begin()));
    motion_at(t, y);
    add_account(t, y);
    if (derivatives_) derivatives_->blocks_at((t - begin_t_) / h_, begin_y_, y);
  }

  void interpolate_ends(double t, std::span<double> y) override {
    if (t == end_t_ || t == begin_t_ || layout_.derivatives > 0) return interpolate(t, y);
    motion_at(t, y, inner_contacts_ ? Nodes::all : Nodes::ends);
  }

  std::span<const double> sample(double t, int derivative) override {
    const Formula& formula = Formula::get();
    const double theta = (t - begin_t_) / h_;
    const Parts of_w = formula.weights(theta, derivative), of_u = formula.weights_over_pole(of_w);
    const std::size_t n = layout_.nodes;
    for (const std::size_t k : selected_) {
      const bool rate = entries_[k] >= n;
      const std::size_t i = rate ? entries_[k] - n : entries_[k];
      const double sum = combined(rate ? of_w : of_u, x_[i]);
      const double w = begin_y_[n + i];
      if (derivative == 0)
        sampled_[k] = rate ? w + sum : begin_y_[i] + h_ * (theta * w + sum);
      else
        sampled_[k] = rate ? sum / h_ : w + sum;
    }
    return sampled_;
  }

  // Their weights are the same in each step.
  std::span<const PointValues> samples(double, double, int derivative, std::span<const std::size_t> asked) override {
    const Formula& formula = Formula::get();
    const Samples& theta = points_of_step();
    std::vector<PointValues>& points = points_[derivative == 0 ? 0 : 1];
    const std::size_t n = layout_.nodes;
    for (const std::size_t k : derivative == 0 ? std::span<const std::size_t>(selected_) : asked) {
      const bool rate = entries_[k] >= n;
      const std::size_t i = rate ? entries_[k] - n : entries_[k];
      const double w = begin_y_[n + i];
      Samples values = combined(formula.samples(derivative, !rate), x_[i]);
      if (derivative == 0)
        values = rate ? (w + values).eval() : (begin_y_[i] + h_ * (w * theta + values)).eval();
      else
        values = rate ? (values / h_).eval() : (w + values).eval();
      Samples::Map(points[k].data()) = values;
    }
    return points;
  }

  std::span<const PointValues> form_samples(double begin, double end) override {
    if (forms_.empty()) return {};
    const Formula& formula = Formula::get();
    if (begin == begin_t_ && end == end_t_)
      sample_forms(points_of_step(), formula.samples(0, true), formula.samples(0, false));
    else
      sample_forms_of_part(begin, end);
    return form_points_;
  }

  void select(std::span<const std::size_t> sampled) override { selected_.assign(sampled.begin(), sampled.end()); }

 private:
  // By the weights of u and of w at the parts theta of the step.
  void sample_forms(const Samples& theta, const std::array<Samples, parts>& of_u,
                    const std::array<Samples, parts>& of_w) {
    const std::size_t n = layout_.nodes;
    for (std::size_t k = 0; k < forms_.size(); ++k) {
      Complex of_displacements{}, of_velocities{};
      double start = 0.0, slope = 0.0;
      for (std::size_t m = 0; m < forms_[k].count; ++m) {
        const std::size_t entry = form_entries_[forms_[k].entries[m]];
        const double weight = forms_[k].weights[m];
        start += weight * begin_y_[entry];
        if (entry < n) slope += weight * begin_y_[n + entry];
        Complex& sum = entry < n ? of_displacements : of_velocities;
        sum = sum + weight * x_[entry < n ? entry : entry - n];
      }
      Samples::Map(form_points_[k].data()) =
          start + h_ * (slope * theta + combined(of_u, of_displacements)) + combined(of_w, of_velocities);
    }
  }

  void sample_forms_of_part(double begin, double end) {
    const Formula& formula = Formula::get();
    Samples theta = Samples::Zero();
    std::array<Samples, parts> of_u, of_w;
    of_u.fill(theta), of_w.fill(theta);
    for (std::size_t j = 0; j <= stages; ++j) {
      const auto at = static_cast<Eigen::Index>(j);
      theta[at] = (point_of(begin, end, stages, j) - begin_t_) / h_;
      const Parts weights = formula.weights(theta[at], 0), over_pole = formula.weights_over_pole(weights);
      for (std::size_t l = 0; l < parts; ++l) of_w[l][at] = weights[l], of_u[l][at] = over_pole[l];
    }
    sample_forms(theta, of_u, of_w);
  }

  void notice(std::span<const double> y) { derivatives_ ? weights_.fill(y, weight_) : weights_.notice(y); }

  // The next length after a step of length h. As fast modes die out, steps of one error grow by one factor: that goes
  // on (Gustafsson's predictive control).
  void grow(double h, double error) {
    // The error estimate is one of h^8.
    const auto eighth_root = [](double x) { return std::sqrt(std::sqrt(std::sqrt(x))); };
    double factor = safety / eighth_root(error);
    if (last_length_ > 0.0) factor *= std::max(1.0, h / last_length_ * eighth_root(last_error_ / error));
    factor = std::clamp(factor, largest_cut, largest_growth);
    last_length_ = h, last_error_ = error;
    if (h == step_ && factor < worth_a_factor && factor > safety) return;
    // A step that was cut short says nothing against the length.
    step_ = h == step_ ? h * factor : std::max(step_, h * factor);
  }

  double next_length() {
    const double remaining = stop_ - begin_t_;
    step_ = std::min(step_, longest_);
    if (step_ >= remaining * (1.0 - 1e-9)) return remaining;
    return step_ > 0.5 * remaining ? 0.5 * remaining : step_;
  }

  std::size_t closed_contacts() const {
    std::size_t closed = 0;
    for (std::size_t i = 0; i < system_.contacts().size(); ++i) closed += system_.contacts().closed(i) ? 1 : 0;
    return closed;
  }

  // Evaluates the state that a step begins with: the end of a step that a contact change cuts is none.
  void evaluate() {
    const std::span<const double> y(end_y_);
    system_.force(end_t_, y.first(layout_.nodes), y.subspan(layout_.nodes, layout_.nodes), force_);
    systems_.multiply_stiffness(y.subspan(layout_.nodes, layout_.nodes), stiff_rate_);
    ++statistics_.rhs_evaluations;
  }

  // The new state, and the error in multiples of what is allowed.
  double attempt(double h) {
    h_ = h;
    if (factorised_ != h) {
      systems_.factorise(h);
      factorised_ = h;
      ++statistics_.matrix_factorisations;
    }
    const double rounding = systems_.rounding();
    systems_.refine(rounding * weights_.largest_displacement() > weights_.displacement_tolerance() ||
                    rounding * weights_.largest_velocity() > weights_.velocity_tolerance());
    const bool loaded = system_.load().varies();
    if (loaded) gather_load(h);
    systems_.solve(force_, stiff_rate_, loaded, x_);
    sorted_ = false;
    statistics_.linear_solves += lanes;
    // The velocity of a massless node is dependent; a rigid contact has no spring, so weights are those of the fields.
    const double weight_u = weights_.weight_of_displacement(), weight_w = weights_.weight_of_velocity();
    const Inertia& inertia = system_.bar().inertia();
    const auto [rate, way, rate_error, way_error] =
        move_nodes(h, x_, {inertia.massive_begin(), inertia.massive_end()}, begin_y_, end_y_);
    if (!(rate + way <= std::numeric_limits<double>::max())) throw not_finite();
    double error = std::max({rate_error * weight_w, way_error * weight_u, std::numeric_limits<double>::min()});
    if (loaded) error = std::max(error, load_tail_.error(system_.bar(), h, weight_u, weight_w));
    if (derivatives_)
      error = std::max(error, derivatives_->attempt(systems_, {begin_t_, h, end_of_step()}, begin_y_, x_, weight_,
                                                    end_y_, statistics_));
    return error;
  }

  double end_of_step() const { return h_ == stop_ - begin_t_ ? stop_ : begin_t_ + h_; }

  // Changes of the load over the step, by its values at the stages.
  void gather_load(double h) {
    const Formula& formula = Formula::get();
    const std::size_t n = layout_.nodes;
    const std::span<const double> y(begin_y_);
    for (std::size_t m = 0; m < stages; ++m) {
      const double t = m + 1 == stages ? std::min(begin_t_ + h, stop_) : begin_t_ + formula.nodes[m] * h;
      system_.force(t, y.first(n), y.subspan(n, n), load_change_);
      const Complex share = {h * formula.of_load[m].re, h * formula.of_load[m].im};
      for (std::size_t i = 0; i < n; ++i) {
        const double change = load_change_[i] - force_[i];
        if (m == 0)
          x_[i] = {share.re * change, share.im * change};
        else
          x_[i].re += share.re * change, x_[i].im += share.im * change;
        load_tail_.add(m, i, change);
      }
    }
  }

  void finish() {
    end_t_ = end_of_step();
    const std::span<double> y(end_y_);
    system_.complete_displacement(end_t_, layout_.u(y));
    system_.complete_velocity(end_t_, layout_.u(y), layout_.w(y));
    add_account(end_t_, y);
    if (derivatives_) derivatives_->evaluate(systems_, end_t_, end_y_);
  }

  // Displacements of all nodes, or of the first and the last ones only, which the velocities of massless ends depend
  // on; or nothing but these nodes.
  enum class Nodes { all, velocities, ends };
  void motion_at(double t, std::span<double> y, Nodes nodes = Nodes::all) {
    const double theta = (t - begin_t_) / h_;
    const Formula& formula = Formula::get();
    const Parts w = formula.weights(theta, 0), u = formula.weights_over_pole(w);
    const std::size_t n = layout_.nodes;
    if (!std::exchange(sorted_, true)) sort_by_part();
    // Sums over the parts of several nodes at once; takes() wants five.
    const auto move = [&](std::size_t i, auto size, auto displaced) {
      using Values = Eigen::Array<double, decltype(size)::value, 1>;
      Values of_w = Values::Zero(), of_u = Values::Zero();
      for (std::size_t l = 0; l < parts; ++l) {
        const auto part = Eigen::Map<const Values>(by_part_.data() + l * n + i);
        of_w += w[l] * part;
        if constexpr (displaced) of_u += u[l] * part;
      }
      const auto velocity = Eigen::Map<const Values>(begin_y_.data() + n + i);
      Eigen::Map<Values>(y.data() + n + i) = velocity + of_w;
      if constexpr (displaced)
        Eigen::Map<Values>(y.data() + i) =
            Eigen::Map<const Values>(begin_y_.data() + i) + h_ * (theta * velocity + of_u);
    };
    // The last ones of the nodes twice, where they are no multiple of the width.
    const auto move_all = [&](auto size) {
      move(0, size, std::true_type());
      for (std::size_t i = size; nodes != Nodes::ends && i + size < n; i += size)
        nodes == Nodes::all ? move(i, size, std::true_type()) : move(i, size, std::false_type());
      move(n - size, size, std::true_type());
    };
    if (n < 8 || nodes == Nodes::ends)
      move_all(std::integral_constant<std::size_t, 4>());
    else
      move_all(std::integral_constant<std::size_t, 8>());
    system_.complete_displacement(t, layout_.u(y));
  }

  std::span<const double> accelerations(double t) override {
    const Parts weights = Formula::get().weights((t - begin_t_) / h_, 1);
    accelerations_.resize(system_.bar().inertia().row_values());
    row_values(
        layout_.nodes, [&](std::size_t i) { return combined(weights, x_[i]) / h_; }, accelerations_);
    return accelerations_;
  }

  // One part of all nodes behind the other.
  void sort_by_part() {
    const std::size_t n = layout_.nodes;
    by_part_.resize(parts * n);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t l = 0; l < lanes; ++l) {
        by_part_[l * n + i] = x_[i].re[l];
        by_part_[(lanes + l) * n + i] = x_[i].im[l];
      }
  }

  // At `until` within the step, or its end.
  void add_account(double until, std::span<double> y) {
    if (inner_.empty()) return;
    const double half = 0.5 * (end_t_ - begin_t_), middle = begin_t_ + half;
    const auto at = [&](double s) {
      return energy_flow(
          system_, layout_, middle + s * half,
          [&](double t, std::span<double> inner) {
            motion_at(t, inner, system_.bar().side() ? Nodes::all : Nodes::velocities);
          },
          [&](double t) { return accelerations(t); }, inner_);
    };
    const auto at_gauss = [&] {
      const double length = end_t_ - begin_t_;
      if (GaussPowers::takes(system_.bar()))
        return gauss_powers_(system_, layout_, std::span(begin_y_).subspan(layout_.nodes, layout_.nodes), x_, begin_t_,
                             length);
      std::array<StepPowers::Flow, StepPowers::of_gauss> flows;
      for (std::size_t k = 0; k < flows.size(); ++k) flows[k] = at(StepPowers::nodes()[k]);
      return flows;
    };
    const StepPowers::Flow sum =
        until == end_t_ ? powers_.over_step(end_t_ - begin_t_, at_gauss()) : powers_.up_to((until - middle) / half, at);
    const std::size_t first = 2 * layout_.nodes;
    for (std::size_t k = 0; k < layout_.account(); ++k) y[first + k] = begin_y_[first + k] + sum[k];
  }

  PenalisedSystem& system_;
  const Layout layout_;
  Statistics& statistics_;
  ErrorWeights weights_;
  ShiftedSystems systems_;
  std::optional<std::uint64_t> taken_;  // revision that the systems are of
  std::optional<double> factorised_;    // length that they are factorised for
  double longest_, step_;               // the length to be tried next
  // A leg that begins with an impact, or with initial data, begins with fast waves: its first step is short.
  bool stirred_ = false, inner_contacts_ = false;
  std::size_t closed_ = 0;
  double stirred_step_ = std::numeric_limits<double>::infinity();
  double last_length_ = 0.0, last_error_ = 1.0;                // of the last step of the leg
  double stop_ = 0.0, begin_t_ = 0.0, end_t_ = 0.0, h_ = 0.0;  // of the leg, and of the last step
  std::vector<double> begin_y_, end_y_, weight_;
  std::vector<double> force_, stiff_rate_, load_change_;  // F and K w where the run is
  LoadTail load_tail_;
  std::vector<Complex> x_;
  std::vector<double> accelerations_;  // of a time of the account
  std::vector<double> by_part_;        // x_ sorted by part, once the step is interpolated
  bool sorted_ = false;
  std::vector<std::size_t> entries_, selected_;  // entries that can be sampled; the positions of those that are
  std::vector<double> sampled_, inner_;
  std::array<std::vector<PointValues>, 2> points_;  // of samples(): values and rates
  StepPowers powers_;
  GaussPowers gauss_powers_;
  std::optional<StepDerivatives> derivatives_;
};

}  // namespace

bool takes(const BarSystem& system) {
  return system.bar().damped() && ShiftedSystems::middle_of(system.inertia().matrix());
}

std::unique_ptr<LegStepper> make_stepper(const StepperParts& run, const Tolerance& tolerance) {
  return std::make_unique<Stepper>(run, tolerance);
}

}  // namespace viscobar::radau
