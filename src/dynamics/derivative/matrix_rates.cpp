#include "dynamics/derivative/matrix_rates.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/assembly/assembled.hpp"

namespace viscobar {

namespace {

const Bar& rates_of(const Direction& direction, std::size_t piece) {
  return direction.members.empty() ? direction.bar : direction.members[piece].bar;
}

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

// The initial velocities of a scene beside that of a bar, its ends moved as those: where one is held, they are by its
// motion, too.
std::vector<double> moving_from_the_start(const BarSystem& bar, Scene beside, const Mesh& mesh) {
  beside.left_input.motion = bar.inputs()[0].motion, beside.right_input.motion = bar.inputs()[1].motion;
  const BarSystem system(beside, mesh, bar.mass());
  std::vector<double> v = system.initial_state().v;
  const Lift rate = system.frame().moving() ? system.frame().lift(0.0, 1) : Lift{};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] += rate.at(system.frame().share(i));
  return v;
}

// None where all are 0.
ElementSprings springs_of(const BarSystem& bar, std::vector<double> springs) {
  if (std::ranges::all_of(springs, [](double spring) { return spring == 0.0; })) springs.clear();
  return {bar.unknowns(), std::move(springs)};
}

}  // namespace

MatrixRates::MatrixRates(const BarSystem& bar, const Direction& direction, const LoadDifference* difference) {
  std::vector<double> elastic(bar.mesh().elements, 0.0), viscous(elastic);
  const std::vector<Piece>& pieces = bar.elements().pieces();
  const std::array massless = {bar.inertia().massive_begin() == 1, bar.inertia().massive_end() < bar.size()};
  const double mass = bar.bar().density * bar.bar().length, spring = bar.bar().modulus / bar.bar().length;
  const auto change = [&](double rate, double of) { relative_change_ += std::abs(rate) / of; };
  const auto stretched = [&](std::size_t p) { return rates_of(direction, p).length / pieces[p].bar.length; };
  const auto growth = [&](std::size_t p) {  // rho' + rho L'/L
    return rates_of(direction, p).density + pieces[p].bar.density * stretched(p);
  };
  const auto mass_times = [&](auto&& factor) {
    return assembled(pieces, [&](const Piece& piece) {
      BandedMatrix own = inertia_matrix(piece.mesh, bar.mass(), massless[0], massless[1], piece.section.get());
      return own *= factor(static_cast<std::size_t>(&piece - pieces.data()));
    });
  };
  bool inertial = false, longer = false;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const Piece& piece = pieces[p];
    const Bar& rates = rates_of(direction, p);
    if (piece.rigid()) {
      inertial |= direction.members[p].mass != 0.0;
      change(direction.members[p].mass, piece.mass);
    } else {
      const double modulus = rates.modulus - piece.bar.modulus * stretched(p);
      const double viscosity = rates.viscosity - piece.bar.viscosity * stretched(p);
      for (std::size_t e = 0; e < piece.mesh.elements; ++e) {
        elastic[piece.first + e] = modulus / piece.stretch(e);
        viscous[piece.first + e] = viscosity / piece.stretch(e);
      }
      inertial |= growth(p) != 0.0, longer |= stretched(p) != 0.0;
      if (direction.members.empty()) of_bar_ = {growth(p) / piece.bar.density, viscosity, modulus};
      change(rates.density, piece.bar.density), change(rates.modulus, piece.bar.modulus);
      change(rates.viscosity, std::sqrt(mass * spring) * bar.bar().length), change(stretched(p), 1.0);
    }
    if (p + 1 == pieces.size() || direction.data.chain[p].joint.kind != JointKind::spring) continue;
    const Joint& joint = direction.members[p].joint;
    elastic[piece.last()] = joint.stiffness, viscous[piece.last()] = joint.damping;
    change(joint.stiffness, direction.data.chain[p].joint.stiffness);
    change(joint.damping, std::sqrt(mass * spring));
  }
  if (inertial) {
    whole_ = mass_times(growth);
    for (std::size_t p = 0; p < pieces.size(); ++p)
      if (pieces[p].rigid()) whole_.diagonal[pieces[p].first] += direction.members[p].mass;
  }
  if (bar.side() && longer) of_side_ = mass_times(stretched);
  if (difference) take_difference(bar, direction, *difference, massless, elastic, viscous);
  if (!whole_.diagonal.empty()) {
    inertia_ = restrict_to(whole_, bar.unknowns().first_node(), bar.size());
    held_ = {whole_.end_row(false), whole_.end_row(true)};
  }
  if (!bar.frame().moving()) whole_ = {};
  elastic_ = springs_of(bar, std::move(elastic)), viscous_ = springs_of(bar, std::move(viscous));
}

// Central differences: of scenes 1e-5 apart they keep ten digits.
void MatrixRates::take_difference(const BarSystem& bar, const Direction& direction, const LoadDifference& difference,
                                  const std::array<bool, 2>& massless, std::vector<double>& elastic,
                                  std::vector<double>& viscous) {
  const Direction::Beside& beside = *direction.beside;
  const double times = difference.times;
  const BarSystem &after = *difference.after, &before = *difference.before;
  const auto whole = [&](const Scene& scene, const Mesh& mesh) {
    return inertia_of(pieces_of(scene, mesh), bar.mass(), massless);
  };
  add_difference(whole(beside.after, beside.mesh_after), whole(beside.before, beside.mesh_before), times, whole_);
  if (bar.side()) add_difference(after.side()->mass(), before.side()->mass(), times, of_side_);
  for (std::size_t e = 0; e < bar.mesh().elements; ++e) {
    const auto add = [&](double Bar::*number, double stretch_after, double stretch_before, double& rate) {
      rate += times * (after.bar().*number / stretch_after - before.bar().*number / stretch_before);
    };
    add(&Bar::modulus, after.elements().stretch(e), before.elements().stretch(e), elastic[e]);
    add(&Bar::viscosity, after.elements().rate_stretch(e), before.elements().rate_stretch(e), viscous[e]);
    relative_change_ =
        std::max(relative_change_, std::abs(after.elements().stretch(e) / before.elements().stretch(e) - 1.0) * times);
  }
  of_bar_ = {};
}

std::vector<double> start_of_masses(const BarSystem& bar, const Direction& direction,
                                    const LoadDifference* difference) {
  const State initial = bar.initial_state();
  std::vector<double> start;
  if (difference) {
    start.resize(bar.size());
    const auto add = [&](const BarSystem& beside, const Scene& scene, const Mesh& mesh, double times) {
      std::vector<double> v = beside.initial_state().v;
      if (bar.frame().moving()) v = moving_from_the_start(bar, scene, mesh);
      for (std::size_t i = 0; i < v.size(); ++i) start[i] += times * v[i];
    };
    add(*difference->after, direction.beside->after, direction.beside->mesh_after, difference->times);
    add(*difference->before, direction.beside->before, direction.beside->mesh_before, -difference->times);
  }
  if (!bar.elements().is_chain()) return start;
  const std::vector<Piece>& pieces = bar.elements().pieces();
  Scene scene = direction.data;
  scene.left_input = scene.right_input = {};
  const MovingFrame frame = bar.frame().resting(bar.side());
  const Lift rate = frame.moving() ? frame.lift(0.0, 1) : Lift{};
  bool changes = false, by_moments = false;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const Piece& piece = pieces[p];
    const Member& rates = direction.members[p];
    const double growth = piece.rigid() ? rates.mass / piece.mass
                                        : rates.bar.density / piece.bar.density + rates.bar.length / piece.bar.length;
    scene.chain[p].velocity = [growth, own = rates.velocity](double x) {
      return growth == 0.0 ? 0.0 : growth * own(x);
    };
    changes |= growth != 0.0;
    for (std::size_t j = p > 0 && pieces[p - 1].last() == piece.first ? 1 : 0; j < piece.mesh.nodes() && rates.velocity;
         ++j)
      if (const std::size_t i = piece.first + j - bar.unknowns().first_node(); i < initial.v.size())
        by_moments |=
            initial.v[i] != rates.velocity(piece.mesh.node(j)) - (frame.moving() ? rate.at(frame.share(i)) : 0.0);
  }
  if (!changes || !by_moments) return start;
  const BarSystem without_masses(scene, bar.mesh(), bar.mass());
  const MatrixRates matrices(bar, direction, nullptr);
  std::vector<double> gained = without_masses.initial_state().v, lost(bar.size());
  if (frame.moving()) {
    // The rows have the product of M with the velocity of the frame, not its moments.
    std::vector<double> whole(bar.mesh().nodes()), product(whole);
    std::ranges::copy(initial.v, bar.unknowns().part(std::span(whole)).begin());
    frame.add_lift(rate, whole);
    matrices.whole().multiply(whole, product);
    std::ranges::copy(bar.unknowns().part(std::span(product)), lost.begin());
  } else {
    matrices.inertia().multiply(initial.v, lost);
  }
  without_masses.inertia().accelerate(lost);
  start.resize(bar.size());
  for (std::size_t i = 0; i < lost.size(); ++i) start[i] += gained[i] - lost[i];
  return start;
}

}  // namespace viscobar
