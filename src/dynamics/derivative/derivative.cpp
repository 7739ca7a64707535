#include "dynamics/derivative/derivative.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/assembly/assembled.hpp"
#include "dynamics/contact_forces.hpp"
#include "dynamics/indicator.hpp"
#include "dynamics/load/nodal_load.hpp"
#include "dynamics/load/nodal_moments.hpp"
#include "dynamics/natural_scales.hpp"

namespace viscobar {

namespace {

// d zeta / d restitution of damping_ratio(); infinite at 0.
double damping_ratio_rate(double restitution) {
  if (restitution <= 0.0) return -std::numeric_limits<double>::infinity();
  const double logarithm = std::log(restitution), square = std::numbers::pi * std::numbers::pi;
  return -square / (restitution * std::pow(square + logarithm * logarithm, 1.5));
}

BarSystem in_frame_of(const BarSystem& bar, BarSystem data, const std::optional<Direction::Beside>& beside) {
  if (beside)
    data.add_load({std::make_shared<const BarSystem>(beside->after, beside->mesh_after, bar.mass()),
                   std::make_shared<const BarSystem>(beside->before, beside->mesh_before, bar.mass()),
                   0.5 / beside->apart});
  if (bar.side()) data.take_side(bar);
  return bar.frame().follows() ? data.following() : data;
}

// The data of s: springs, dashpots and masses are those of the bar.
Scene with_supports(Scene data, const BarSystem& bar) {
  data.side.reset();
  for (const auto& [input, of_bar] :
       {std::pair{&data.left_input, &bar.inputs()[0]}, {&data.right_input, &bar.inputs()[1]}})
    input->stiffness = of_bar->stiffness, input->dashpot = of_bar->dashpot, input->mass = of_bar->mass,
    input->stop = of_bar->stop;
  return data;
}

const LoadDifference* difference_of(const BarSystem& data) {
  return data.load() && data.load()->difference ? &*data.load()->difference : nullptr;
}

}  // namespace

Derivative::Derivative(PenalisedSystem& system, const Penalty& penalty, const Direction& direction)
    : system_(system),
      data_(in_frame_of(system.bar(),
                        {with_supports(direction.data, system.bar()), system.bar().mesh(), system.bar().mass()},
                        direction.beside)),
      motion_(data_, penalty),
      contacts_(system.contacts()),
      of_contacts_(motion_.contacts()),
      matrices_(system.bar(), direction, difference_of(data_)),
      start_(start_of_masses(system.bar(), direction, difference_of(data_))),
      relative_change_(matrices_.relative_change() + std::abs(direction.restitution)),
      added_(system.size(), 0.0) {
  const Bar& bar = system.bar().bar();
  if (direction.epsilon != 0.0) relative_change_ += std::abs(direction.epsilon / *penalty.epsilon);
  for (const Support& support : system.bar().supports()) {
    const bool right = system.bar().unknowns().is_right(support.unknown);
    const EndInput& rates = right ? direction.data.right_input : direction.data.left_input;
    if (rates.stiffness == 0.0 && rates.dashpot == 0.0 && rates.mass == 0.0) continue;
    supports_.push_back({support.unknown, rates.stiffness, rates.dashpot, rates.mass});
    relative_change_ +=
        (std::abs(rates.stiffness) * bar.length / bar.modulus + std::abs(rates.dashpot) / bar.impedance() +
         std::abs(rates.mass) / (bar.density * bar.length)) /
        area_at(system.bar(), right);
  }
  take_sides(direction);
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    laws_.push_back(contacts_[i].law.stop() ? stop_rates(i, direction)
                    : contacts_[i].rigid    ? LawRates{0.0, 0.0}
                                            : spring_rates(i, penalty, direction));
  if (system.bar().frame().moving() && matrices_.inertial()) {
    std::vector<double> share(system.bar().mesh().nodes()), product(share);
    for (const bool right : {false, true}) {
      const auto of_end = lifted(Lift{right ? 0.0 : 1.0, right ? 1.0 : 0.0});
      for (std::size_t j = 0; j < share.size(); ++j) share[j] = of_end(j);
      matrices_.whole().multiply(share, product);
      const auto of_unknowns = system.bar().unknowns().part(std::span(product));
      lift_inertia_[right].assign(of_unknowns.begin(), of_unknowns.end());
    }
  }
  driven_ = matrices_.any() || !supports_.empty() || !sides_.empty() ||
            std::ranges::any_of(laws_, [](const LawRates& law) { return law.stiffness != 0.0 || law.damping != 0.0; });
  if (driven_) motion_.load().add(added_, {});
}

Derivative::LawRates Derivative::stop_rates(std::size_t i, const Direction& direction) {
  const ContactNode& contact = contacts_[i];
  const Stop& stop = *contact.law.stop();
  LawRates rates{0.0, 0.0};
  if (const auto& own = contact.joint > 0               ? direction.members[contact.joint - 1].joint.stop
                        : contact.where == Where::right ? direction.data.right_input.stop
                                                        : direction.data.left_input.stop)
    rates = {own->stiffness, own->damping};
  relative_change_ += std::abs(rates.stiffness) / stop.stiffness;
  const double least_damping = system_.bar().bar().slowness();  // of lambda; small beside that of a dashpot
  if (rates.damping != 0.0) relative_change_ += std::abs(rates.damping) / std::max(stop.damping, least_damping);
  if (!stop.linear()) of_contacts_.linearise(i, {});
  return rates;
}

// k = weight / epsilon, b = 2 zeta (k m)^(1/2)
Derivative::LawRates Derivative::spring_rates(std::size_t i, const Penalty& penalty, const Direction& direction) const {
  const ContactNode& contact = contacts_[i];
  const PenaltyLaw& law = contact.law.linear();
  const Inertia& inertia = system_.bar().inertia();
  const double stiffer = (contact.where == Where::span ? direction.bar.length / system_.bar().bar().length : 0.0) -
                         direction.epsilon / *penalty.epsilon;
  LawRates rates{law.stiffness * stiffer, 0.5 * law.damping * stiffer};
  if (law.damping > 0.0) rates.damping += 0.5 * law.damping * mass_growth(contact);
  if (direction.restitution != 0.0 && !contact.massless)
    rates.damping += 2.0 * damping_ratio_rate(penalty.restitution) * direction.restitution *
                     std::sqrt(law.stiffness * inertia.contact_mass(contact));
  return rates;
}

void Derivative::take_sides(const Direction& direction) {
  const BarSystem& bar = system_.bar();
  const SideRows* own = bar.side();
  if (!own) return;
  const SideResistance given = direction.data.side.value_or(SideResistance{});
  const LoadDifference* difference = difference_of(data_);
  // Rates of k or c at the nodes.
  const auto rates_of = [&](const SpaceFunction& rate, const Places& places,
                            double (SideRows::*of_side)(std::size_t) const) {
    std::vector<double> rates = side_values(bar.elements(), bar.mass(), rate, places);
    rates.resize(bar.mesh().nodes());
    for (std::size_t j = 0; difference && j < rates.size(); ++j)
      rates[j] +=
          difference->times * ((difference->after->side()->*of_side)(j) - (difference->before->side()->*of_side)(j));
    return rates;
  };
  std::vector<double> stiffness = rates_of(given.stiffness, given.stiffness_places, &SideRows::stiffness),
                      drag = rates_of(given.drag, given.drag_places, &SideRows::drag);
  const BandedMatrix& of_mass = matrices_.of_side();
  const auto relative = [&](double of_stiffness, double of_drag) {
    return std::abs(of_stiffness) * bar.bar().length * bar.bar().length / bar.bar().modulus +
           std::abs(of_drag) * bar.bar().length / bar.bar().impedance();
  };
  double change = 0.0;
  for (std::size_t j = 0; j < stiffness.size(); ++j) {
    const double mass = own->mass().diagonal[j],
                 grown = of_mass.size() > 0 && mass > 0.0 ? of_mass.diagonal[j] / mass : 0.0;
    change = std::max(change, relative(stiffness[j] + grown * own->stiffness(j), drag[j] + grown * own->drag(j)));
  }
  relative_change_ += change;
  const auto any = [](const std::vector<double>& rates) {
    return std::ranges::any_of(rates, [](double rate) { return rate != 0.0; });
  };
  if (any(stiffness) || any(drag)) sides_.emplace_back(own->mass(), std::move(stiffness), std::move(drag));
  if (of_mass.size() == 0) return;
  stiffness.resize(bar.mesh().nodes()), drag.resize(bar.mesh().nodes());
  for (std::size_t j = 0; j < stiffness.size(); ++j) stiffness[j] = own->stiffness(j), drag[j] = own->drag(j);
  sides_.emplace_back(of_mass, std::move(stiffness), std::move(drag));
}

bool Derivative::multiply_inertia(std::span<const double> x, std::span<double> out) const {
  const auto has_mass = [](const Support& support) { return support.mass != 0.0; };
  if (!matrices_.inertial() && std::ranges::none_of(supports_, has_mass)) return false;
  if (matrices_.inertial())
    matrices_.inertia().multiply(x, out);
  else
    std::ranges::fill(out, 0.0);
  for (const Support& support : supports_) out[support.unknown] += support.mass * x[support.unknown];
  return true;
}

// m'/m of Inertia::contact_mass, 1/m = d.(rho M)^{-1} d: m d.(rho M)^{-1} (rho M)' (rho M)^{-1} d; under a span
// obstacle m is the sum of a row.
double Derivative::mass_growth(const Contact& contact) const {
  const Inertia& inertia = system_.bar().inertia();
  if (contact.where == Where::span) {
    double rate = matrices_.inertial() ? row_sum(matrices_.inertia(), contact.unknown) : 0.0;
    for (const Support& support : supports_)
      if (support.unknown == contact.unknown) rate += support.mass;
    return rate / inertia.contact_mass(contact);
  }
  std::vector<double> gained(added_.size()), lost(gained);
  gained[contact.unknown] = 1.0;
  if (contact.joint > 0) gained[contact.unknown - 1] = -1.0;
  inertia.accelerate(gained);
  if (!multiply_inertia(gained, lost)) return 0.0;
  inertia.accelerate(lost);
  return contact.of(lost) / contact.of(gained);
}

State Derivative::initial_state(double t) const {
  State state = data_.initial_state();
  for (std::size_t i = 0; i < start_.size(); ++i) state.v[i] += start_[i];
  const MovingFrame& frame = data_.frame();
  if (frame.follows()) frame.resting(data_.side()).change(frame, t, state.u, state.v);
  return state;
}

double Derivative::relative_scale(double end) const {
  double most = displacement_of_data(data_, end);
  for (const Contact& contact : data_.contacts()) most = std::max(most, std::abs(contact.gap));
  return most / natural_scales(system_.bar(), end).displacement + relative_change_;
}

void Derivative::take_contacts() {
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (of_contacts_.closed(i) != contacts_.closed(i)) of_contacts_.set_closed(i, contacts_.closed(i));
}

// The strain of the element beside that row, times its length, outwards.
double Derivative::stretch(std::size_t end, std::size_t last, std::span<const double> x, std::span<const double> origin,
                           const BarSystem& walls) const {
  const auto at = [&](std::size_t i) { return x[i] + (origin.empty() ? 0.0 : origin[i]); };
  if (x.size() == 1) return at(0) - *walls.unknowns().wall(!walls.unknowns().left_fixed());
  return at(last) - at(end == 0 ? last + 1 : last - 1);
}

double Derivative::lift_inertia(std::size_t unknown, const Lift& lift) const {
  if (lift_inertia_[0].empty()) return 0.0;
  return lift.left * lift_inertia_[0][unknown] + lift.right * lift_inertia_[1][unknown];
}

double Derivative::displacement(std::size_t end, std::span<const double> u) const {
  return u[end] + contacts_.origin().at(end) + lift_[0].of(system_.bar().unknowns().is_right(end));
}

// The stretch of the lift, as stretch() is of u.
double Derivative::lift_stretch(std::size_t end, std::size_t last, const Lift& lift) const {
  const BarSystem& bar = system_.bar();
  const std::size_t element = bar.elements().beside(last);
  const double stretched = lift.at(bar.elements().share(element + 1)) - lift.at(bar.elements().share(element));
  return bar.unknowns().is_right(end) ? stretched : -stretched;
}

void Derivative::drive(const Moment& at) {
  const BarSystem& bar = system_.bar();
  const bool lifts = bar.frame().moving();
  for (int order = 0; lifts && order < 3; ++order)
    lift_[static_cast<std::size_t>(order)] = system_.load().lift(at.t, order);
  for (std::size_t i = 0; contacts_.bend() && i < contacts_.size(); ++i)
    if (contacts_[i].law.bent())
      of_contacts_.linearise(i, contacts_[i].law.tangent(contacts_.clearance(i, at.u), contacts_[i].of(at.w)));
  if (!driven_) return;
  const std::size_t n = added_.size();
  if (matrices_.inertial() && !at.a.empty()) {
    matrices_.inertia().multiply(at.a, added_);
    for (double& force : added_) force = -force;
  } else {
    std::ranges::fill(added_, 0.0);
  }
  matrices_.elastic().subtract(in_frame(at.u), added_);
  matrices_.viscous().subtract(bar.unknowns().at_nodes(at.w), added_);
  if (lifts) add_lift(lift_[0], lift_[1], lift_[2], added_);
  std::array<double, 2> rates{};  // of the rows of ends that follow
  for (const bool right : {false, true}) {
    const std::size_t end = bar.unknowns().end(right);
    if (n > 1 && bar.inertia().massless(end) && !bar.bar().damped())
      rates[right] = -matrices_.elastic()[bar.elements().beside(end)] *
                     (stretch(end, end, at.w, {}, bar) + (lifts ? lift_stretch(end, end, lift_[1]) : 0.0));
  }
  for (const SideRows& side : sides_)
    side.subtract(side.resistance(placed(at.u), moving(at.w)), bar.unknowns().first_node(), n, added_);
  for (const auto& [node, stiffness, dashpot, mass] : supports_) {
    const bool right = bar.unknowns().is_right(node);
    added_[node] -= stiffness * displacement(node, at.u) + dashpot * (at.w[node] + lift_[1].of(right)) +
                    mass * ((at.a.empty() ? 0.0 : at.a[node]) + lift_[2].of(right));
  }
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    if (!contacts_.closed(i) || contacts_[i].holds) continue;
    const std::size_t node = contacts_[i].unknown;
    const double push = law_rate(i, contacts_.clearance(i, at.u), contacts_[i].of(at.w));
    added_[node] += push;
    if (contacts_[i].joint > 0) {
      added_[node - 1] -= push;
      continue;
    }
    if (node == 0) rates[0] -= laws_[i].stiffness * at.w[node];
    if (node + 1 == n) rates[1] -= laws_[i].stiffness * at.w[node];
  }
  motion_.load().add(added_, rates);
}

// Adds the force of the lift alone, without that of a side and of the ends.
void Derivative::add_lift(const Lift& lift, const Lift& rate, const Lift& acceleration, std::span<double> out) const {
  matrices_.elastic().subtract(lifted(lift), out);
  matrices_.viscous().subtract(lifted(rate), out);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] -= lift_inertia(i, acceleration);
}

void Derivative::add_frame_rate(double t, std::span<double> rate) const {
  const BarSystem& bar = system_.bar();
  if (!bar.frame().moving()) return;
  const Lift velocity = system_.load().lift(t, 1), acceleration = system_.load().lift(t, 2);
  const auto [before, after] = system_.load().beside(t);
  Lift jerk;
  if (before < after) {
    const Lift early = system_.load().lift(before, 2), late = system_.load().lift(after, 2);
    jerk = {(late.left - early.left) / (after - before), (late.right - early.right) / (after - before)};
  }
  add_lift(velocity, acceleration, jerk, rate);
  for (const SideRows& side : sides_)
    side.subtract(side.resistance(lifted(velocity), lifted(acceleration)), bar.unknowns().first_node(), rate.size(),
                  rate);
  for (const auto& [node, stiffness, dashpot, mass] : supports_) {
    const bool right = bar.unknowns().is_right(node);
    rate[node] -= stiffness * velocity.of(right) + dashpot * acceleration.of(right) + mass * jerk.of(right);
  }
}

double Derivative::drive_row(std::size_t end, double t, double u, double u_next, double w, double w_next) const {
  const double apart = contacts_.origin().at(end == 0 ? 1 : end - 1) - contacts_.origin().at(end);
  const std::size_t element = system_.bar().elements().beside(end);
  const double elastic = matrices_.elastic()[element], viscous = matrices_.viscous()[element];
  double sum = elastic * (u_next - u + apart) + viscous * (w_next - w);
  if (system_.bar().frame().moving())
    sum -= elastic * lift_stretch(end, end, system_.load().lift(t, 0)) +
           viscous * lift_stretch(end, end, system_.load().lift(t, 1));
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const Contact& contact = contacts_[i];
    if (contact.unknown != end || !contacts_.closed(i) || contacts_[i].holds) continue;
    sum -= contact.sign * laws_[i].stiffness * (contact.sign * u + contact.clearance(contacts_.origin().at(end)));
  }
  return sum;
}

double Derivative::reaction(std::size_t i, const Moment& at, std::span<const double> s, std::span<const double> rate) {
  if (!contacts_.closed(i)) return 0.0;
  // The remainder of its row; the inertia of the neighbours, of the bar itself, is in the added force.
  if (contacts_[i].holds) return viscobar::holding_force(motion_, i, at.t, s, rate);
  return law_reaction(i, at, s, contacts_[i].of(rate));
}

double Derivative::law_reaction(std::size_t i, const Moment& at, std::span<const double> s, double rate) const {
  return of_contacts_[i].law.force(of_contacts_.clearance(i, s), rate) +
         law_rate(i, contacts_.clearance(i, at.u), contacts_[i].of(at.w));
}

double Derivative::law_rate(std::size_t i, double clearance, double w) const {
  const double sign = contacts_[i].sign;
  if (const Stop* law = contacts_[i].law.bent())
    return sign * (law->by_stiffness(-clearance, -sign * w) * laws_[i].stiffness +
                   law->by_damping(-clearance, -sign * w) * laws_[i].damping);
  return -sign * laws_[i].stiffness * clearance - laws_[i].damping * w;
}

double Derivative::push_rate(std::size_t i, const Moment& at, std::span<const double> s,
                             std::span<const double> rate) const {
  const Contact& contact = contacts_[i];
  return viscobar::push_rate(contacts_, i, of_contacts_.clearance(i, s), contact.of(rate), contact.of(at.w),
                             {.stiffness = laws_[i].stiffness, .damping = laws_[i].damping});
}

double Derivative::opening_reaction(std::size_t i, const Moment& at, std::span<const double> s,
                                    std::span<const double> rate) {
  return contacts_[i].holds ? reaction(i, at, s, rate) : contacts_[i].sign * row_reaction(motion_, i, at.t, s, rate);
}

void Derivative::expand(double t, std::span<const double> s, std::span<const double> rate, std::span<double> u,
                        std::span<double> v) const {
  data_.unknowns().expand_displacement(s, u);
  data_.unknowns().expand_velocity(rate, v);
  if (!data_.frame().moving()) return;
  data_.frame().add_lift(motion_.load().lift(t, 0), u);
  data_.frame().add_lift(motion_.load().lift(t, 1), v);
}

}  // namespace viscobar
