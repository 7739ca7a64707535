#include "viscobar/dynamics/load_vector.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "dynamics/finite_load.hpp"
#include "dynamics/load/moments.hpp"
#include "dynamics/load/nodal_load.hpp"
#include "dynamics/pieces.hpp"
#include "scene/times.hpp"

namespace viscobar {

namespace {

double history_at(const TimeFunction& history, double t) {
  return finite_load(
      t, [&] { return history(t); }, [&] { return fmt::format("the history of the load at t = {}", t); });
}

double density_at(const SpaceTimeFunction& density, double x, double t) {
  return finite_load(
      t, [&] { return density(x, t); }, [&] { return fmt::format("the load at x = {}, t = {}", x, t); });
}

}  // namespace

template <class Kind>
const Kind* LoadVector::load_as() const {
  return load_ && load_->distributed ? std::get_if<Kind>(&*load_->distributed) : nullptr;
}

LoadVector::LoadVector(const BarSystem& system, double step) : system_(system), load_(system.load()), step_(step) {
  steady_ = load_as<NodalLoad::Steady>() && !load_->varying_forces && !system.frame().moving() && !load_->difference;
  if (load_ && load_->difference && load_->difference->after->loaded())
    for (const auto* of : {&load_->difference->after, &load_->difference->before}) {
      const LoadVector& one = difference_.emplace_back(**of);
      breaks_.insert(breaks_.end(), one.breaks_.begin(), one.breaks_.end());
    }
  if (const auto* separable = load_as<NodalLoad::Separable>()) {
    breaks_.push_back(separable->breaks);
    if (separable->plus) breaks_.push_back(separable->plus->breaks);
  }
  if (const auto* general = load_as<NodalLoad::General>()) {
    nodal_.resize(2 * system.mesh().nodes());
    for (std::size_t j = 0; j < system.mesh().nodes(); ++j) nodes_.push_back(system.mesh().node(j));
    breaks_.push_back(general->breaks);
    breaks_at_ = general->breaks_at;
  }
  for (const bool right : {false, true}) {
    const EndInput& input = system.inputs()[right];
    if (load_ && load_->varying_forces && input.force) breaks_.push_back(input.force->breaks);
    if (system.frame().moves(right)) breaks_.push_back(input.motion->breaks);
  }
  std::erase_if(breaks_, [](const NextBreak& one) { return !one; });
  if (!breaks_.empty() || breaks_at_)
    next_.assign(breaks_.size() + (breaks_at_ ? system.mesh().nodes() : 0), -std::numeric_limits<double>::infinity());
  if (!steady_) weighted_.resize(system.size());
}

// Each break is searched for once, when the one before it at its place has been passed.
double LoadVector::next_break(double after, double until) {
  constexpr double never = std::numeric_limits<double>::infinity();
  const Mesh& mesh = system_.mesh();
  double first = never;
  for (std::size_t k = 0; k < next_.size(); ++k) {
    if (next_[k] <= after) {
      const std::size_t whole = breaks_.size();
      next_[k] =
          (k < whole ? breaks_[k](after, until) : breaks_at_(mesh.node(k - whole), after, until)).value_or(never);
    }
    first = std::min(first, next_[k]);
  }
  return first;
}

double LoadVector::enter(double t, double end) {
  if (next_.empty()) return end;
  const double rounding = rounding_of_times(t, end);
  double next = next_break(t - rounding, end + rounding);
  if (next <= t + rounding) {
    first_ = t + rounding;
    next = next_break(first_, end + rounding);
  }
  last_ = std::max(first_, next - rounding);
  return next < end - rounding ? next : end;
}

// Times within that are those of breaks of the whole load.
bool LoadVector::breaks_within(double from, double to) const {
  return std::ranges::any_of(breaks_, [&](const NextBreak& one) { return one(from, to).value_or(to) < to; });
}

bool LoadVector::jump(double t, double end, double apart, std::span<double> force, std::span<double> rate) {
  const double rounding = rounding_of_times(t, end);
  if (!breaks_within(t - rounding, t + rounding)) return false;
  const std::pair kept(first_, last_);
  first_ = -std::numeric_limits<double>::infinity(), last_ = -first_;
  std::ranges::fill(force, 0.0);
  std::ranges::fill(rate, 0.0);
  const auto add = [&](double time, double of_force, double of_rate) {
    const std::span<const double> load = at(time);
    for (std::size_t i = 0; i < force.size(); ++i) {
      force[i] += of_force * load[i];
      rate[i] += of_rate / apart * load[i];
    }
  };
  for (const double side : {-1.0, 1.0}) {
    const double near = t + side * rounding, far = near + side * apart;
    const bool has_rate = far > 0.0 && !breaks_within(std::min(near, far), std::max(near, far));
    add(near, side, has_rate ? -1.0 : 0.0);
    if (has_rate) add(far, 0.0, 1.0);
  }
  std::tie(first_, last_) = kept;
  time_.reset();
  return true;
}

std::span<const double> LoadVector::at(double t) {
  if (steady_) return load_as<NodalLoad::Steady>()->weighted;
  t = inside(t);
  if (time_ == t) return weighted_;
  ++evaluations_;
  find_distributed(t);
  add_inputs(t);
  double times = difference_.empty() ? 0.0 : load_->difference->times;
  for (LoadVector& one : difference_) {
    const std::span<const double> load = one.at(t);
    for (std::size_t i = 0; i < weighted_.size(); ++i) weighted_[i] += times * load[i];
    times = -times;
  }
  time_ = t;
  return weighted_;
}

// At all nodes at once, where it can; one that is not finite is named by density_at().
void LoadVector::density_at_nodes(const SpaceTimeFunction& density, double t, std::span<double> values) const {
  if (const auto* rows = density.target<RowFunction>())
    rows->row(nodes_, t, values);
  else
    for (std::size_t j = 0; j < values.size(); ++j) values[j] = density_at(density, nodes_[j], t);
  for (std::size_t j = 0; j < values.size(); ++j)
    if (!std::isfinite(values[j])) density_at(density, nodes_[j], t);
}

void LoadVector::find_distributed(double t) {
  if (!load_ || !load_->distributed) {
    std::ranges::fill(weighted_, 0.0);
  } else if (const auto* steady = load_as<NodalLoad::Steady>()) {
    std::ranges::copy(steady->weighted, weighted_.begin());
  } else if (const auto* separable = load_as<NodalLoad::Separable>()) {
    const double history = separable_history(t);
    for (std::size_t i = 0; i < weighted_.size(); ++i) weighted_[i] = history * separable->weighted[i];
    if (const NodalLoad::Separable* const plus = separable->plus.get()) {
      const double other = history_at(plus->history, t);
      for (std::size_t i = 0; i < weighted_.size(); ++i) weighted_[i] += other * plus->weighted[i];
    }
  } else {
    const auto& general = std::get<NodalLoad::General>(*load_->distributed);
    const Mesh& mesh = system_.mesh();
    const std::span<double> values = std::span(nodal_).first(mesh.nodes()),
                            product = std::span(nodal_).last(mesh.nodes());
    if (general.breaks_in_x) {
      std::ranges::fill(product, 0.0);
      add_moments(t, 0, mesh.elements, [&](std::size_t j, double part) { product[j] += part; });
    } else {
      density_at_nodes(general.density, t, values);
      general.mass.multiply(values, product);
    }
    std::ranges::copy(product.subspan(system_.unknowns().first_node(), weighted_.size()), weighted_.begin());
  }
}

template <class Add>
void LoadVector::add_moments(double t, std::size_t first, std::size_t last, Add&& add) const {
  const auto& general = std::get<NodalLoad::General>(*load_->distributed);
  const NextBreak breaks = [&](double after, double until) { return general.breaks_in_x(t, after, until); };
  for (const Piece& piece : system_.elements().pieces()) {
    const std::size_t from = std::max(first, piece.first), to = std::min(last, piece.last());
    if (from >= to) continue;
    viscobar::add_moments(
        piece.mesh, system_.mass(), piece.section.get(), from - piece.first, to - piece.first,
        [&](double x) { return density_at(general.density, piece.begin + x, t); }, shifted(breaks, piece.begin),
        [&](std::size_t j, double part) { add(piece.first + j, part); });
  }
}

// A step back from the start there is no motion.
Lift LoadVector::lift(double t, int derivative) const {
  return step_ > 0.0 && t >= step_ ? system_.frame().lift(t, derivative, step_) : system_.frame().lift(t, derivative);
}

// The given forces, of which a fixed end has none, and in a frame that moves -(E K + eta K) of what is linear in one
// bar, and what that does to the supports.
std::array<double, 2> LoadVector::end_forces(double t) const {
  t = inside(t);
  std::array<double, 2> forces{}, of_lift{};
  for (const bool right : {false, true})
    if (const auto& force = system_.inputs()[right].force; force && load_->varying_forces)
      forces[right] = finite_load(
          t, [&] { return force->value(t); },
          [&] { return fmt::format("the force at the {} end at t = {}", right ? "right" : "left", t); });
  if (system_.frame().moving()) {
    const Lift at = lift(t, 0), rate = lift(t, 1);
    const Bar& bar = system_.bar();
    const double pull = system_.elements().is_chain()
                            ? 0.0
                            : (bar.modulus * (at.right - at.left) + bar.viscosity * (rate.right - rate.left)) /
                                  system_.elements().whole_stretch();
    of_lift = {pull, -pull};
    for (const Support& support : system_.supports()) {
      const bool right = system_.unknowns().is_right(support.unknown);
      of_lift[right] -= support.stiffness * at.of(right) + support.dashpot * rate.of(right);
    }
  }
  for (const bool right : {false, true})
    forces[right] = system_.unknowns().wall(right) ? 0.0 : forces[right] + of_lift[right];
  return forces;
}

void LoadVector::add_inputs(double t) {
  const std::array<double, 2> forces = end_forces(t);
  if (system_.frame().moving()) {
    const Lift acceleration = lift(t, 2);
    for (std::size_t i = 0; i < weighted_.size(); ++i) weighted_[i] -= system_.frame().inertial_force(acceleration, i);
    if (system_.frame().has_inner_force()) {
      const Lift displacement = lift(t, 0), velocity = lift(t, 1);
      for (std::size_t i = 0; i < weighted_.size(); ++i)
        weighted_[i] += system_.frame().inner_force(displacement, velocity, i);
    }
  }
  weighted_.front() += forces[0];
  weighted_.back() += forces[1];
}

double LoadVector::at(double t, std::size_t unknown) const {
  if (steady_) return load_as<NodalLoad::Steady>()->weighted[unknown];
  t = inside(t);
  double sum = distributed(t, unknown + system_.unknowns().first_node());
  if (!difference_.empty())
    sum += load_->difference->times * (difference_[0].at(t, unknown) - difference_[1].at(t, unknown));
  const bool left = unknown == 0, right = unknown + 1 == system_.size();
  if (left || right) {
    const std::array<double, 2> forces = end_forces(t);
    sum += (left ? forces[0] : 0.0) + (right ? forces[1] : 0.0);
  }
  if (!system_.frame().moving()) return sum;
  if (system_.frame().has_inner_force()) sum += system_.frame().inner_force(lift(t, 0), lift(t, 1), unknown);
  const Lift acceleration = lift(t, 2);
  return sum - system_.frame().inertial_force(acceleration, unknown);
}

std::optional<std::span<const double>> LoadVector::profile() const {
  if (!load_ || system_.frame().moving() || !difference_.empty()) return std::nullopt;
  if (!load_->distributed) return std::span<const double>();
  if (const auto* steady = load_as<NodalLoad::Steady>()) return steady->weighted;
  const auto* separable = load_as<NodalLoad::Separable>();
  if (separable && !separable->plus) return separable->weighted;
  return std::nullopt;
}

std::optional<double> LoadVector::factor(std::size_t unknown) const {
  const auto* separable = load_as<NodalLoad::Separable>();
  const bool forced = load_ && load_->varying_forces && (unknown == 0 || unknown + 1 == system_.size());
  if (!separable || separable->plus || forced || system_.frame().moving() || !difference_.empty()) return std::nullopt;
  return separable->weighted[unknown];
}

double LoadVector::history(double t) const {
  return load_as<NodalLoad::Separable>() ? separable_history(inside(t)) : 1.0;
}

double LoadVector::separable_history(double t) const {
  if (history_time_ != t) history_ = history_at(load_as<NodalLoad::Separable>()->history, t), history_time_ = t;
  return history_;
}

double LoadVector::at_held(double t, bool right) const {
  const double own = distributed(inside(t), right ? system_.mesh().elements : 0);
  if (difference_.empty()) return own;
  return own + load_->difference->times * (difference_[0].at_held(t, right) - difference_[1].at_held(t, right));
}

double LoadVector::distributed(double t, std::size_t node) const {
  if (!load_ || !load_->distributed) return 0.0;
  const auto entry = [&](const auto& of) {
    const std::size_t unknown = node - system_.unknowns().first_node();  // beyond all of a fixed end
    return unknown < of.weighted.size() ? of.weighted[unknown] : of.held[node > 0];
  };
  if (const auto* steady = load_as<NodalLoad::Steady>()) return entry(*steady);
  if (const auto* separable = load_as<NodalLoad::Separable>()) {
    const double own = separable_history(t) * entry(*separable);
    return separable->plus ? own + history_at(separable->plus->history, t) * entry(*separable->plus) : own;
  }
  const auto& general = std::get<NodalLoad::General>(*load_->distributed);
  if (general.breaks_in_x) {
    double moment = 0.0;
    add_moments(t, node > 0 ? node - 1 : 0, std::min(node + 1, system_.mesh().elements),
                [&](std::size_t j, double part) { moment += j == node ? part : 0.0; });
    return moment;
  }
  const auto density = [&](std::size_t j) { return density_at(general.density, system_.mesh().node(j), t); };
  const bool coupled = !general.mass.is_diagonal();
  double sum = general.mass.diagonal[node] * density(node);
  if (coupled && node > 0) sum += general.mass.below(node - 1) * density(node - 1);
  if (coupled && node + 1 < general.mass.size()) sum += general.mass.above(node) * density(node + 1);
  for (const OneSidedRow& one : general.mass.one_sided)
    for (std::size_t k = 0; k < 3 && one.row == node; ++k) sum += one.entries[k] * density(one.column(k));
  return sum;
}

}  // namespace viscobar
