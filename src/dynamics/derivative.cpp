#include "dynamics/derivative.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/contact_forces.hpp"
#include "dynamics/indicator.hpp"
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

}  // namespace

MomentBuilder::MomentBuilder(const PenalisedSystem& system, std::span<Derivative* const> derivatives)
    : system_(system), stiffness_(system.bar()) {
  for (const Derivative* one : derivatives) {
    const Derivative::MatrixRates rates = one->matrix_rates();
    asks_for_inertia_ |= rates.inertia != 0.0;
    if (rates.modulus != 0.0) strain_.resize(system.size()), strain_rate_.resize(system.size());
    if (rates.viscosity != 0.0) strain_rate_.resize(system.size());
  }
  if (asks_for_inertia_) inertia_.resize(system.size());
}

Moment MomentBuilder::operator()(double t, std::span<const double> u, std::span<const double> w,
                                 std::span<const double> a) {
  if (!strain_.empty()) {
    if (const std::span<const double> origin = system_.contacts().origin().values(); origin.empty())
      stiffness_.multiply([&](std::size_t i) { return u[i]; }, strain_);
    else
      stiffness_.multiply([&](std::size_t i) { return u[i] + origin[i]; }, strain_);
    stiffness_.add_walls(system_.bar().unknowns().wall(false).value_or(0.0),
                         system_.bar().unknowns().wall(true).value_or(0.0), strain_);
  }
  if (!strain_rate_.empty()) stiffness_.multiply([&](std::size_t i) { return w[i]; }, strain_rate_);
  const bool inertial = asks_for_inertia_ && !a.empty();
  if (inertial) system_.bar().inertia().matrix().multiply(a, inertia_);
  return {t, u, w, a, inertial ? inertia_ : std::span<const double>{}, strain_, strain_rate_};
}

Derivative::Derivative(PenalisedSystem& system, const Penalty& penalty, const Direction& direction)
    : system_(system),
      data_(in_frame_of(system.bar(),
                        {with_supports(direction.data, system.bar()), system.bar().mesh(), system.bar().mass()},
                        direction.beside)),
      motion_(data_, penalty),
      contacts_(system.contacts()),
      of_contacts_(motion_.contacts()),
      added_(system.size(), 0.0) {
  const Bar& bar = system.bar().bar();
  const double stretched = direction.bar.length / bar.length;
  modulus_ = direction.bar.modulus - bar.modulus * stretched;
  viscosity_ = direction.bar.viscosity - bar.viscosity * stretched;
  inertia_ = direction.bar.density / bar.density + stretched;
  const double crossing = bar.transit();
  relative_change_ = std::abs(direction.bar.density) / bar.density + std::abs(direction.bar.modulus) / bar.modulus +
                     std::abs(direction.bar.viscosity) / (bar.modulus * crossing) + std::abs(stretched) +
                     std::abs(direction.restitution);
  if (system.bar().elements().is_chain()) take_chain(direction);
  if (direction.beside) take_difference(direction);
  if (direction.epsilon != 0.0) relative_change_ += std::abs(direction.epsilon / *penalty.epsilon);
  for (const Support& support : system.bar().supports()) {
    const bool right = system.bar().unknowns().is_right(support.unknown);
    const EndInput& rates = right ? direction.data.right_input : direction.data.left_input;
    const double mass = rates.mass - inertia_ * support.mass;
    if (rates.stiffness == 0.0 && rates.dashpot == 0.0 && mass == 0.0) continue;
    supports_.push_back({support.unknown, rates.stiffness, rates.dashpot, mass});
    relative_change_ += std::abs(rates.stiffness) * bar.length / bar.modulus +
                        std::abs(rates.dashpot) / bar.impedance() + std::abs(rates.mass) / (bar.density * bar.length);
  }
  take_side(direction, stretched);
  const double least_damping = bar.slowness();  // of lambda; small beside that of a dashpot
  for (std::size_t i = 0; i < system.contacts().size(); ++i) {
    LawRates rates{0.0, 0.0};
    if (const Stop* stop = system.contacts()[i].law.stop()) {
      const Contact& contact = system.contacts()[i];
      const bool right = contact.where == Where::right;
      if (const auto& own = contact.joint > 0 ? direction.members[contact.joint - 1].joint.stop
                            : right           ? direction.data.right_input.stop
                                              : direction.data.left_input.stop)
        rates = {own->stiffness, own->damping};
      relative_change_ += std::abs(rates.stiffness) / stop->stiffness;
      if (rates.damping != 0.0) relative_change_ += std::abs(rates.damping) / std::max(stop->damping, least_damping);
      if (!stop->linear()) of_contacts_.linearise(i, {});
    } else if (!system.contacts()[i].rigid) {
      const PenaltyLaw& law = system.contacts()[i].law.linear();
      const Contact& contact = system.contacts()[i];
      // k = weight / epsilon, b = 2 zeta (k m)^(1/2)
      const double stiffer = (contact.where == Where::span ? stretched : 0.0) - direction.epsilon / *penalty.epsilon;
      rates.stiffness = law.stiffness * stiffer;
      rates.damping = 0.5 * law.damping * (stiffer + inertia_);
      if (chain_ && law.damping > 0.0) rates.damping += 0.5 * law.damping * mass_growth(contact);
      for (const Support& support : supports_)
        if (support.unknown == contact.unknown && law.damping > 0.0 && !chain_)
          rates.damping += 0.5 * law.damping * support.mass / system.bar().inertia().contact_mass(contact);
      if (direction.restitution != 0.0 && !system.bar().inertia().massless(contact.unknown))
        rates.damping += 2.0 * damping_ratio_rate(penalty.restitution) * direction.restitution *
                         std::sqrt(law.stiffness * system.bar().inertia().contact_mass(contact));
    }
    laws_.push_back(rates);
  }
  if (system.bar().frame().moving() && (chain_ || inertia_ != 0.0)) {
    const BarSystem& of = system.bar();
    std::vector<double> share(of.mesh().nodes()), product(of.mesh().nodes());
    for (const bool right : {false, true}) {
      for (std::size_t j = 0; j < share.size(); ++j)
        share[j] = Lift{right ? 0.0 : 1.0, right ? 1.0 : 0.0}.at(of.elements().share(j));
      (chain_ ? chain_->whole : of.inertia().whole()).multiply(share, product);
      for (double& one : product) one *= chain_ ? 1.0 : inertia_;
      const auto of_unknowns = std::span(product).subspan(of.unknowns().first_node(), of.size());
      lift_inertia_[right].assign(of_unknowns.begin(), of_unknowns.end());
    }
  }
  driven_ = chain_ || !supports_.empty() || side_ || modulus_ != 0.0 || viscosity_ != 0.0 || inertia_ != 0.0 ||
            std::ranges::any_of(laws_, [](const LawRates& law) { return law.stiffness != 0.0 || law.damping != 0.0; });
  if (driven_) motion_.load().add(added_, {});
}

// M goes like L.
void Derivative::take_side(const Direction& direction, double stretched) {
  const SideRows* own = system_.bar().side();
  if (!own || (!direction.data.side && stretched == 0.0)) return;
  const Mesh& mesh = system_.bar().mesh();
  const Bar& bar = system_.bar().bar();
  const SideResistance given = direction.data.side.value_or(SideResistance{});
  std::vector<double> stiffness =
      side_values(system_.bar().elements(), system_.bar().mass(), given.stiffness, given.stiffness_places);
  std::vector<double> drag = side_values(system_.bar().elements(), system_.bar().mass(), given.drag, given.drag_places);
  stiffness.resize(mesh.nodes()), drag.resize(mesh.nodes());
  double change = 0.0;
  for (std::size_t j = 0; j < mesh.nodes(); ++j) {
    stiffness[j] += stretched * own->stiffness(j);
    drag[j] += stretched * own->drag(j);
    change = std::max(change, std::abs(stiffness[j]) * bar.length * bar.length / bar.modulus +
                                  std::abs(drag[j]) * bar.length / bar.impedance());
  }
  relative_change_ += change;
  side_ = own->with(std::move(stiffness), std::move(drag));
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

// The strain of the element beside an end, times its length, outwards.
double Derivative::stretch(std::size_t end, std::span<const double> x, std::span<const double> origin,
                           const BarSystem& walls) const {
  const auto at = [&](std::size_t i) { return x[i] + (origin.empty() ? 0.0 : origin[i]); };
  if (end == 0 && x.size() > 1) return at(0) - at(1);
  if (end > 0) return at(end) - at(end - 1);
  return at(0) - *walls.unknowns().wall(!walls.unknowns().left_fixed());
}

double Derivative::lift_inertia(std::size_t unknown, const Lift& lift) const {
  if (lift_inertia_[0].empty()) return 0.0;
  return lift.left * lift_inertia_[0][unknown] + lift.right * lift_inertia_[1][unknown];
}

double Derivative::displacement(std::size_t end, std::span<const double> u) const {
  return u[end] + contacts_.origin().at(end) + lift_[0].of(system_.bar().unknowns().is_right(end));
}

// The stretch of the lift, as stretch() is of u.
double Derivative::lift_stretch(std::size_t end, const Lift& lift) const {
  const BarSystem& bar = system_.bar();
  const std::size_t element = bar.elements().beside(end);
  const double stretched = lift.at(bar.elements().share(element + 1)) - lift.at(bar.elements().share(element));
  return bar.unknowns().is_right(end) ? stretched : -stretched;
}

// Stress of the lift by the derivatives of the coefficients.
double Derivative::lift_stress(const Lift& lift, const Lift& rate) const {
  return (modulus_ * (lift.right - lift.left) + viscosity_ * (rate.right - rate.left)) /
         system_.bar().elements().whole_stretch();
}

auto Derivative::placed(std::span<const double> u) const {
  return [this, of = system_.bar().unknowns().displacement_at_nodes(u)](std::size_t j) {
    const BarSystem& bar = system_.bar();
    const std::size_t i = j - bar.unknowns().first_node();
    return of(j) + (i < bar.size() ? contacts_.origin().at(i) : 0.0) + lift_[0].at(bar.elements().share(j));
  };
}

auto Derivative::moving(std::span<const double> w) const {
  return [this, of = system_.bar().unknowns().at_nodes(w)](std::size_t j) {
    return of(j) + lift_[1].at(system_.bar().elements().share(j));
  };
}

void Derivative::drive(const Moment& at) {
  if (system_.bar().frame().moving())
    for (int order = 0; order < 3; ++order) lift_[static_cast<std::size_t>(order)] = system_.load().lift(at.t, order);
  for (std::size_t i = 0; contacts_.bend() && i < contacts_.size(); ++i)
    if (contacts_[i].law.bent())
      of_contacts_.linearise(i, contacts_[i].law.tangent(contacts_.clearance(i, at.u), contacts_[i].of(at.w)));
  if (!driven_) return;
  const std::size_t n = added_.size();
  const BarSystem& bar = system_.bar();
  bool begun = false;
  const auto add = [&](double factor, std::span<const double> force) {
    if (factor == 0.0 || force.empty()) return;
    if (begun)
      for (std::size_t i = 0; i < n; ++i) added_[i] -= factor * force[i];
    else
      for (std::size_t i = 0; i < n; ++i) added_[i] = -factor * force[i];
    begun = true;
  };
  add(inertia_, at.inertia);
  add(modulus_, at.strain);
  add(viscosity_, at.strain_rate);
  if (!begun) std::ranges::fill(added_, 0.0);
  if (chain_) {
    const auto subtract = [&] {
      for (std::size_t i = 0; i < n; ++i) added_[i] -= product_[i];
    };
    if (!at.a.empty()) {
      chain_->inertia.multiply(at.a, product_);
      subtract();
    }
    const Lift &placed_by = lift_[0], &moved_by = lift_[1];
    const auto share = [&](std::size_t i) { return bar.frame().moving() ? bar.frame().share(i) : 0.0; };
    chain_->stiffness.multiply(
        [&](std::size_t i) { return at.u[i] + contacts_.origin().at(i) + placed_by.at(share(i)); }, product_);
    chain_->stiffness.add_walls(bar.unknowns().wall(false).value_or(0.0) + placed_by.left,
                                bar.unknowns().wall(true).value_or(0.0) + placed_by.right, product_);
    subtract();
    chain_->viscosity.multiply([&](std::size_t i) { return at.w[i] + moved_by.at(share(i)); }, product_);
    chain_->viscosity.add_walls(moved_by.left, moved_by.right, product_);
    subtract();
  }
  std::array<double, 2> rates{};
  if (n > 1 && bar.inertia().has_massless() && !bar.bar().damped())
    rates = {modulus_ * (at.w[1] - at.w[0]) / bar.elements().stretch_beside(0),
             modulus_ * (at.w[n - 2] - at.w[n - 1]) / bar.elements().stretch_beside(n - 1)};
  if (bar.frame().moving()) {
    add_frame();
    const double strain_rate = modulus_ * (lift_[1].right - lift_[1].left) / bar.elements().whole_stretch();
    rates[0] += strain_rate, rates[1] -= strain_rate;
  }
  if (side_) side_->subtract(side_->resistance(placed(at.u), moving(at.w)), bar.unknowns().first_node(), n, added_);
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

// Adds the lift's strain and inertia; K lift is zero but in the rows of ends.
void Derivative::add_frame() {
  const std::size_t n = added_.size();
  const BarSystem& bar = system_.bar();
  const double stress = lift_stress(lift_[0], lift_[1]);
  if (!bar.unknowns().left_fixed()) added_[0] += stress;
  if (!bar.unknowns().right_fixed()) added_[n - 1] -= stress;
  if (!lift_inertia_[0].empty())
    for (std::size_t i = 0; i < n; ++i) added_[i] -= lift_inertia(i, lift_[2]);
}

void Derivative::add_frame_rate(double t, std::span<double> rate) const {
  const BarSystem& bar = system_.bar();
  if (!bar.frame().moving()) return;
  const Lift velocity = system_.load().lift(t, 1), acceleration = system_.load().lift(t, 2);
  const double stress = lift_stress(velocity, acceleration);
  if (!bar.unknowns().left_fixed()) rate.front() += stress;
  if (!bar.unknowns().right_fixed()) rate.back() -= stress;
  if (side_) {
    const auto at = [&bar](const Lift& lift) {
      return [&bar, lift](std::size_t j) { return lift.at(bar.elements().share(j)); };
    };
    side_->subtract(side_->resistance(at(velocity), at(acceleration)), bar.unknowns().first_node(), rate.size(), rate);
  }
  bool massive = inertia_ != 0.0;
  for (const auto& [node, stiffness, dashpot, mass] : supports_) {
    const bool right = bar.unknowns().is_right(node);
    rate[node] -= stiffness * velocity.of(right) + dashpot * acceleration.of(right);
    massive |= mass != 0.0;
  }
  const auto [before, after] = system_.load().beside(t);
  if (!massive || before >= after) return;
  const Lift early = system_.load().lift(before, 2), late = system_.load().lift(after, 2);
  const Lift jerk{(late.left - early.left) / (after - before), (late.right - early.right) / (after - before)};
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] -= lift_inertia(i, jerk);
  for (const Support& support : supports_)
    rate[support.unknown] -= support.mass * jerk.of(bar.unknowns().is_right(support.unknown));
}

double Derivative::drive_row(std::size_t end, double t, double u, double u_next, double w, double w_next) const {
  const double apart = contacts_.origin().at(end == 0 ? 1 : end - 1) - contacts_.origin().at(end);
  double sum =
      (modulus_ * (u_next - u + apart) + viscosity_ * (w_next - w)) / system_.bar().elements().stretch_beside(end);
  if (system_.bar().frame().moving()) {
    const double stress = lift_stress(system_.load().lift(t, 0), system_.load().lift(t, 1));
    sum += end == 0 ? stress : -stress;
  }
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
  const Contact& contact = contacts_[i];
  return of_contacts_[i].law.force(of_contacts_.clearance(i, s), contact.of(rate)) +
         law_rate(i, contacts_.clearance(i, at.u), contact.of(at.w));
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

double Derivative::holding_force(bool right, double t, const Nodal& bar, const Nodal& s) const {
  const std::size_t element = right ? system_.bar().mesh().elements - 1 : 0;
  const auto stretch = [&](std::span<const double> x) { return x[element + 1] - x[element]; };
  const double pull = elastic_of(element) * stretch(bar.u) + viscous_of(element) * stretch(bar.v);
  double inertia = inertia_ * system_.bar().inertia().held(right, bar.a);
  for (std::size_t k = 0; chain_ && k < std::min<std::size_t>(3, bar.a.size()); ++k)
    inertia += chain_->held[right][k] * bar.a[right ? bar.a.size() - 1 - k : k];
  const auto at = [](std::span<const double> x) { return [x](std::size_t j) { return x[j]; }; };
  const double side = side_ ? side_->at_end(right, side_->resistance(at(bar.u), at(bar.v))) : 0.0;
  return (right ? pull : -pull) + side + inertia +
         system_.bar().holding_force(right, s.u, s.v, s.a, motion_.load().held(right, t));
}

double Derivative::momentum(std::size_t end, const Moment& at, std::span<const double> s,
                            std::span<const double> rate) const {
  const std::size_t n = s.size();
  const auto row = [&](const BandedMatrix& inertia, std::span<const double> x) {
    double sum = inertia.diagonal[end] * x[end];
    if (!inertia.off_diagonal.empty() && n > 1)
      sum += inertia.off_diagonal[end == 0 ? 0 : end - 1] * x[end == 0 ? 1 : end - 1];
    for (const OneSidedRow& one : inertia.one_sided)
      if (one.row == end) sum += one.times(x);
    return sum;
  };
  const BarSystem& bar = system_.bar();
  double sum =
      row(bar.inertia().matrix(), rate) +
      (chain_            ? row(chain_->inertia, at.w)
       : inertia_ == 0.0 ? 0.0
                         : inertia_ * row(bar.inertia().matrix(), at.w)) +
      bar.bar().viscosity / bar.elements().rate_stretch(bar.elements().beside(end)) * stretch(end, s, {}, data_) +
      viscous_of(bar.elements().beside(end)) * stretch(end, at.u, contacts_.origin().values(), bar);
  if (bar.frame().moving())
    sum += lift_inertia(end, lift_[1]) + viscous_of(bar.elements().beside(end)) * lift_stretch(end, lift_[0]);
  for (const Support& support : bar.supports())
    if (support.unknown == end) sum += support.dashpot * s[end];
  if (const SideRows* own = bar.side()) {
    const auto of_s = data_.unknowns().displacement_at_nodes(s);
    sum += own->at_end(bar.unknowns().is_right(end), [&](std::size_t j) { return own->drag(j) * of_s(j); });
  }
  if (side_)
    sum += side_->at_end(bar.unknowns().is_right(end),
                         [&, u = placed(at.u)](std::size_t j) { return side_->drag(j) * u(j); });
  for (const Support& support : supports_)
    if (support.unknown == end)
      sum += support.dashpot * displacement(end, at.u) +
             support.mass * (at.w[end] + lift_[1].of(bar.unknowns().is_right(end)));
  return sum;
}

double Derivative::elastic_row(std::size_t end, double u, double u_stretch, double s, double s_stretch) const {
  const BarSystem& bar = system_.bar();
  const std::size_t element = bar.elements().beside(end);
  double sum = bar.bar().modulus / bar.elements().stretch(element) * s_stretch + elastic_of(element) * u_stretch;
  for (const Support& support : bar.supports())
    if (support.unknown == end) sum += support.stiffness * s;
  for (const Support& support : supports_)
    if (support.unknown == end) sum += support.stiffness * u;
  return sum;
}

double Derivative::momentum_loss(std::size_t end, const Moment& at, std::span<const double> s) {
  const BarSystem& bar = system_.bar();
  const double sum = elastic_row(end, displacement(end, at.u), stretch(end, at.u, contacts_.origin().values(), bar),
                                 s[end], stretch(end, s, {}, data_));
  return sum + side_row(end, placed(at.u), data_.unknowns().displacement_at_nodes(s)) +
         (bar.frame().moving() ? elastic_of(bar.elements().beside(end)) * lift_stretch(end, lift_[0]) : 0.0) -
         (motion_.load().at(end, at.t) - added_[end]);
}

double Derivative::energy(const Moment& at, std::span<const double> s, std::span<const double> rate) const {
  const BarSystem& bar = system_.bar();
  const Mesh& mesh = bar.mesh();
  // Fields of the bar itself, over all nodes.
  std::vector<double> u(mesh.nodes()), w(u), of_u(u), of_w(u);
  bar.unknowns().expand_displacement(at.u, u);
  const std::span<const double> origin = contacts_.origin().values();
  for (std::size_t i = 0; i < origin.size(); ++i) u[i + bar.unknowns().first_node()] += origin[i];
  bar.unknowns().expand_velocity(at.w, w);
  bar.frame().add_lift(lift_[0], u);
  bar.frame().add_lift(lift_[1], w);
  expand(at.t, s, rate, of_u, of_w);
  const bool whole = bar.frame().moving();
  const BandedMatrix& inertia = whole ? bar.inertia().whole() : bar.inertia().matrix();
  const std::size_t first = whole ? 0 : bar.unknowns().first_node(), n = inertia.size();
  const double *v = w.data() + first, *of_v = of_w.data() + first;
  double sum = 0.5 * (chain_ ? (whole ? chain_->whole : chain_->inertia).quadratic_form({v, n})
                             : inertia_ * inertia.quadratic_form({v, n}));
  for (std::size_t i = 0; i < n; ++i) sum += inertia.diagonal[i] * v[i] * of_v[i];
  for (std::size_t i = 0; i + 1 < n && !inertia.off_diagonal.empty(); ++i)
    sum += inertia.off_diagonal[i] * (v[i] * of_v[i + 1] + v[i + 1] * of_v[i]);
  for (std::size_t j = 0; j < mesh.elements; ++j) {
    const double strain = u[j + 1] - u[j], of_strain = of_u[j + 1] - of_u[j];
    sum += bar.bar().modulus / bar.elements().stretch(j) * strain * of_strain + 0.5 * elastic_of(j) * strain * strain;
  }
  const auto nodal = [](const std::vector<double>& x) { return [&x](std::size_t j) { return x[j]; }; };
  if (bar.side()) sum += bar.side()->energy_product(nodal(u), nodal(of_u));
  if (side_) sum += side_->energy(nodal(u));
  const auto end = [&](const Support& support) { return support.unknown + bar.unknowns().first_node(); };
  for (const Support& support : bar.supports()) sum += support.stiffness * u[end(support)] * of_u[end(support)];
  for (const Support& support : supports_)
    sum += 0.5 * support.stiffness * u[end(support)] * u[end(support)] +
           0.5 * support.mass * w[end(support)] * w[end(support)];
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const double clearance = contacts_.clearance(i, at.u);
    if (contacts_[i].holds || contacts_[i].moves || clearance >= 0.0) continue;
    if (contacts_[i].law.stop() && !contacts_.closed(i)) continue;
    if (const Stop* law = contacts_[i].law.bent()) {
      sum += law->energy(-clearance) * laws_[i].stiffness / law->stiffness;
      sum -= law->force(-clearance, 0.0) * of_contacts_.clearance(i, s);
      continue;
    }
    sum += clearance *
           (contacts_[i].law.linear().stiffness * of_contacts_.clearance(i, s) + 0.5 * laws_[i].stiffness * clearance);
  }
  return sum;
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
