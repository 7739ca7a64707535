// The part of a derivative that is that of bars in line.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "dynamics/assembly/assembled.hpp"
#include "dynamics/derivative.hpp"
#include "dynamics/load/nodal_load.hpp"

namespace viscobar {

void Derivative::take_chain(const Direction& direction) {
  const BarSystem& bar = system_.bar();
  const std::vector<Piece> pieces = pieces_of(direction.data, bar.mesh());
  std::vector<double> elastic(bar.mesh().elements, 0.0), viscous(elastic);
  const auto inertia_of = [&](const Piece& piece) {
    const Bar& rates = direction.members[static_cast<std::size_t>(&piece - pieces.data())].bar;
    BandedMatrix inertia = inertia_matrix(piece.mesh, bar.mass(), false, false, piece.section.get());
    return inertia *= rates.density + piece.bar.density * rates.length / piece.bar.length;
  };
  BandedMatrix inertia = assembled(pieces, inertia_of);
  const auto change = [&](double rate, double of) { relative_change_ += std::abs(rate) / of; };
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const Piece& piece = pieces[p];
    const Member& rates = direction.members[p];
    const double mass = bar.bar().density * bar.bar().length, spring = bar.bar().modulus / bar.bar().length;
    if (piece.rigid()) {
      inertia.diagonal[piece.first] += rates.mass;
      change(rates.mass, piece.mass);
    } else {
      const double stretched = rates.bar.length / piece.bar.length;
      for (std::size_t e = 0; e < piece.mesh.elements; ++e) {
        elastic[piece.first + e] = (rates.bar.modulus - piece.bar.modulus * stretched) / piece.stretch(e);
        viscous[piece.first + e] = (rates.bar.viscosity - piece.bar.viscosity * stretched) / piece.stretch(e);
      }
      change(rates.bar.density, piece.bar.density), change(rates.bar.modulus, piece.bar.modulus);
      change(rates.bar.viscosity, std::sqrt(mass * spring) * bar.bar().length), change(stretched, 1.0);
    }
    if (p + 1 == pieces.size() || direction.data.chain[p].joint.kind != JointKind::spring) continue;
    elastic[piece.last()] = rates.joint.stiffness, viscous[piece.last()] = rates.joint.damping;
    change(rates.joint.stiffness, direction.data.chain[p].joint.stiffness);
    change(rates.joint.damping, std::sqrt(mass * spring));
  }
  const std::array held = {inertia.end_row(false), inertia.end_row(true)};
  const UnitStiffness stiffness(bar, [&](std::size_t e) { return elastic[e]; });
  const UnitStiffness viscosity(bar, [&](std::size_t e) { return viscous[e]; });
  chain_ = ChainRates{restrict_to(inertia, bar.unknowns().first_node(), bar.size()),
                      held,
                      std::move(elastic),
                      std::move(viscous),
                      stiffness,
                      viscosity,
                      bar.frame().moving() ? inertia : BandedMatrix{}};
  product_.resize(bar.size());
  find_start(direction, pieces);
}

namespace {

// Adds times (a - b); all of one form, or nothing yet.
void add_difference(const BandedMatrix& a, const BandedMatrix& b, double times, BandedMatrix& to) {
  if (to.diagonal.empty()) {
    to = a;
    to *= 0.0;
  }
  const auto add = [times](const auto& one, const auto& other, auto& sum) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += times * (one[i] - other[i]);
  };
  for (std::vector<double> BandedMatrix::*part :
       {&BandedMatrix::diagonal, &BandedMatrix::off_diagonal, &BandedMatrix::skew})
    add(a.*part, b.*part, to.*part);
  for (std::size_t r = 0; r < to.one_sided.size(); ++r)
    add(a.one_sided[r].entries, b.one_sided[r].entries, to.one_sided[r].entries);
}

}  // namespace

// Central differences: of scenes 1e-5 apart they keep ten digits.
void Derivative::take_difference(const Direction& direction) {
  const BarSystem& bar = system_.bar();
  const Direction::Beside& beside = *direction.beside;
  const LoadDifference& difference = *data_.load()->difference;
  const double times = difference.times;
  const auto& after = difference.after;
  const auto& before = difference.before;
  const std::array massless = {bar.inertia().massive_begin() == 1, bar.inertia().massive_end() < bar.size()};
  const auto whole = [&](const Scene& scene, const Mesh& mesh) {
    return inertia_of(pieces_of(scene, mesh), bar.mass(), massless);
  };
  const BandedMatrix late = whole(beside.after, beside.mesh_after), early = whole(beside.before, beside.mesh_before);
  const auto unknowns = [&](const BandedMatrix& all) {
    return restrict_to(all, bar.unknowns().first_node(), bar.size());
  };
  if (!chain_) {  // of one bar, whose own numbers are told by the first three
    BandedMatrix own = whole(direction.data, bar.mesh());
    own *= inertia_;
    chain_ = ChainRates{
        unknowns(own), {own.end_row(false), own.end_row(true)}, {}, {}, UnitStiffness(bar), UnitStiffness(bar), own};
    for (std::size_t e = 0; e < bar.mesh().elements; ++e) {
      chain_->elastic.push_back(modulus_ / bar.elements().stretch(e));
      chain_->viscous.push_back(viscosity_ / bar.elements().stretch(e));
    }
    inertia_ = modulus_ = viscosity_ = 0.0;
  }
  add_difference(unknowns(late), unknowns(early), times, chain_->inertia);
  add_difference(late, early, times, chain_->whole);
  for (const bool right : {false, true})
    for (std::size_t k = 0; k < 3; ++k)
      chain_->held[right][k] += times * (late.end_row(right)[k] - early.end_row(right)[k]);
  for (std::size_t e = 0; e < bar.mesh().elements; ++e) {
    const auto add = [&](double Bar::*number, double stretch_after, double stretch_before, double& rate) {
      rate += times * (after->bar().*number / stretch_after - before->bar().*number / stretch_before);
    };
    add(&Bar::modulus, after->elements().stretch(e), before->elements().stretch(e), chain_->elastic[e]);
    add(&Bar::viscosity, after->elements().rate_stretch(e), before->elements().rate_stretch(e), chain_->viscous[e]);
    relative_change_ = std::max(relative_change_,
                                std::abs(after->elements().stretch(e) / before->elements().stretch(e) - 1.0) * times);
  }
  chain_->stiffness = UnitStiffness(bar, [&](std::size_t e) { return chain_->elastic[e]; });
  chain_->viscosity = UnitStiffness(bar, [&](std::size_t e) { return chain_->viscous[e]; });
  product_.resize(bar.size());
  const std::vector<double> v = after->initial_state().v, v_before = before->initial_state().v;
  start_.resize(bar.size());
  for (std::size_t i = 0; i < v.size(); ++i) start_[i] += times * (v[i] - v_before[i]);
}

// A velocity that enters by its moments, (rho M) w = int rho phi_i u_1, has the derivative of both.
void Derivative::find_start(const Direction& direction, std::span<const Piece> pieces) {
  const BarSystem& bar = system_.bar();
  const State& initial = bar.initial_state();
  Scene start = direction.data;
  start.left_input = start.right_input = {};
  const Lift frame = bar.frame().moving() ? bar.frame().lift(0.0, 1) : Lift{};
  bool changes = false, by_moments = false;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const Piece& piece = pieces[p];
    const Member& rates = direction.members[p];
    const double growth = piece.rigid() ? rates.mass / piece.mass
                                        : rates.bar.density / piece.bar.density + rates.bar.length / piece.bar.length;
    start.chain[p].velocity = [growth, own = rates.velocity, frame, begin = piece.begin,
                               length = bar.mesh().length](double x) {
      return growth == 0.0 ? 0.0 : growth * (own(x) - frame.at((begin + x) / length));
    };
    changes |= growth != 0.0;
    for (std::size_t j = p > 0 && pieces[p - 1].last() == piece.first ? 1 : 0; j < piece.mesh.nodes() && rates.velocity;
         ++j)
      if (const std::size_t i = piece.first + j - bar.unknowns().first_node(); i < initial.v.size())
        by_moments |= initial.v[i] != rates.velocity(piece.mesh.node(j)) -
                                          (bar.frame().moving() ? frame.at(bar.frame().share(i)) : 0.0);
  }
  if (!changes || !by_moments) return;
  const BarSystem without_masses(start, bar.mesh(), bar.mass());
  chain_->inertia.multiply(initial.v, product_);
  without_masses.inertia().accelerate(product_);
  start_ = without_masses.initial_state().v;
  for (std::size_t i = 0; i < product_.size(); ++i) start_[i] -= product_[i];
}

State Derivative::initial_state() const {
  State state = data_.initial_state();
  for (std::size_t i = 0; i < start_.size(); ++i) state.v[i] += start_[i];
  return state;
}

void Derivative::multiply_chain_inertia(std::span<const double> x, std::span<double> out) const {
  chain_->inertia.multiply(x, out);
  for (const Support& support : supports_) out[support.unknown] += support.mass * x[support.unknown];
}

// m'/m of Inertia::contact_mass, 1/m = d.(rho M)^{-1} d: m d.(rho M)^{-1} (rho M)' (rho M)^{-1} d.
double Derivative::mass_growth(const Contact& contact) const {
  std::vector<double> gained(added_.size()), lost(added_.size());
  gained[contact.unknown] = 1.0;
  if (contact.joint > 0) gained[contact.unknown - 1] = -1.0;
  system_.bar().inertia().accelerate(gained);
  multiply_chain_inertia(gained, lost);
  system_.bar().inertia().accelerate(lost);
  return contact.of(lost) / contact.of(gained);
}

std::vector<double> Derivative::joint_forces(const Moment& at, std::span<const double> s,
                                             std::span<const double> rate) {
  std::vector<double> forces;
  const BarSystem& bar = system_.bar();
  for (const JointNodes& joint : bar.elements().joints()) {
    const std::size_t element = joint.node - 1;
    const auto apart = [&](auto&& of) { return of(joint.node) - of(element); };
    if (!joint.contact) {
      forces.push_back(-joint.stiffness * apart(data_.unknowns().displacement_at_nodes(s)) -
                       joint.damping * apart(data_.unknowns().at_nodes(rate)) -
                       elastic_of(element) * apart(bar.unknowns().displacement_at_nodes(at.u)) -
                       viscous_of(element) * apart(bar.unknowns().at_nodes(at.w)));
      continue;
    }
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (contacts_[i].joint == joint.number) forces.push_back(reaction(i, at, s, rate));
  }
  return forces;
}

}  // namespace viscobar
