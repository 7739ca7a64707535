// How fine a mesh the error asked for needs.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "case/run_cost.hpp"
#include "studies/accuracy/plan.hpp"

namespace viscobar::accuracy {

namespace {

constexpr double least_ratio = 1.25, most_ratio = 2.0;  // of two neighbouring meshes

}  // namespace

// The run of a mesh that is to be `steps` below the finest of a ladder, if there is one. Tolerances may be looser than
// the chosen one on coarser meshes, whose differences are larger; steps of a scheme are all the same.
std::optional<Setting> Plan::known_rung(std::size_t elements, std::size_t steps) const {
  const Setting best = at(elements);
  if (runs_.knows(best)) return best;
  if (stepping_ || exact_time_ || steps == 0) return std::nullopt;
  const double looser = steps == 1 ? 3.0 : 10.0, of_pilots = steps >= 3 ? 10.0 * looser_ : looser_;
  for (const Setting& known : runs_.known())
    if (known.elements == elements && known.epsilon == best.epsilon &&
        known.fineness <= std::max(looser, of_pilots) * chosen_.fineness)
      return known;
  return std::nullopt;
}

// The settings of a ladder of up to four meshes, the finest last. Below each is the finest that was run and is coarser
// by 5/4 to 2, else, down to `least` meshes, one of half as many elements, four of them or more. Of a load by nodal
// values one of an odd number: on meshes with nodes in common, what is short is the same wrong wave.
std::vector<Setting> Plan::rungs(std::size_t finest, std::size_t least) const {
  std::vector<Setting> all{at(finest)};
  while (all.size() < most_rungs) {
    const auto above = static_cast<double>(all.back().elements);
    std::optional<Setting> below;
    for (const Setting& known : runs_.known()) {
      if (apart_) break;
      const double ratio = above / static_cast<double>(known.elements);
      if (ratio >= least_ratio && ratio <= most_ratio && (!below || known.elements > below->elements))
        if (const auto rung = known_rung(known.elements, all.size())) below = rung;
    }
    if (!below) {
      const std::size_t half = (all.back().elements + 1) / 2 | (apart_ ? 1 : 0);
      if (all.size() >= least || fewest_at(half) < (as_it_is_ ? 3U : 4U) || half >= all.back().elements) break;
      below = at(half);
      if (!stepping_ && !exact_time_ && all.size() == 3) below = time_pair(half)[1];
    }
    all.push_back(*below);
  }
  std::reverse(all.begin(), all.end());
  return all;
}

// `same`: whether the last two agree on the contact changes. Their alignment is the one that counts.
std::vector<MeshStep> Plan::ladder(const std::vector<Setting>& steps, bool* same) {
  *same = true;
  closing_speed_ = end_speed_ = 0.0;
  for (const Event& event : runs_.of(steps.back()).events) {
    if (event.change != Change::closing) continue;
    closing_speed_ = std::max(closing_speed_, std::abs(event.velocity));
    if (event.where != Where::span) end_speed_ = std::max(end_speed_, std::abs(event.velocity));
  }
  std::vector<MeshStep> result;
  const std::size_t count = steps.size();
  for (std::size_t k = 0; k + 1 < count; ++k)
    result.push_back({steps[k].elements, steps[k + 1].elements, apart(steps[k], steps[k + 1])});
  if (count >= 2) *same = compare_changes(runs_.of(steps[count - 2]), runs_.of(steps[count - 1]), resolution()).same;
  if (count >= 3) result.back().alignment = aligned(steps[count - 3], steps[count - 2], steps[count - 1]);
  return result;
}

// A ladder that has been run. What pilots of a looser tolerance say counts only where the difference of the last two is
// far above the error of that tolerance.
std::vector<MeshStep> Plan::made_ladder(std::size_t finest, std::size_t least, bool* same) {
  constexpr double far = 5.0;
  const std::vector<Setting> settings = rungs(finest, least);
  runs_.make(settings);
  std::vector<MeshStep> steps = ladder(settings, same);
  if (looser_ <= 1.0 || steps.empty() || steps.back().distance >= far * pilot_error_) return steps;
  looser_ = 1.0;
  return made_ladder(finest, least, same);
}

// Two of three coarse meshes may agree by chance. So an order that is seen once counts half, and that of a number, in
// which errors of both signs may cancel, not at all.
SpaceError Plan::seen_error(const std::vector<MeshStep>& steps) const {
  constexpr std::size_t seen_twice = 3;
  constexpr double safety = 1.4, power_of_layers = 2.0;
  const bool once = steps.size() < seen_twice, inside = study_.request.of == Goal::displacement;
  SpaceError result = space_error(steps, once && !inside ? 1.0 : theory_);
  if (once) result.error *= 2.0, result.effectivity *= 2.0;
  result = data_error_.of(result, steps);
  if (steps.empty() || !inside) return result;
  const double layer = safety * layer_error(with(at(steps.back().fine)), end_speed_);
  if (layer <= result.error) return result;
  if (result.error > 0.0) result.effectivity *= layer / result.error;
  result.error = layer;
  result.order = std::min(result.order, power_of_layers);
  if (result.trusted) result.trusted = std::min(*result.trusted, power_of_layers);
  return result;
}

// Coarse meshes and two settings in time and penalty, side by side: what tolerance, epsilon and mesh are needed.
void Plan::pilot() {
  const AccuracyRequest::Given& given = study_.request.given;
  const std::size_t finest =
      given.elements ? with_enough(std::max<std::size_t>(base_.elements / 2, 3)) : pilot_elements_;
  if (!given.elements) chosen_.elements = finest;
  std::vector<Setting> settings = rungs(finest, given.elements ? most_rungs : 2);
  for (const auto& pair : {time_pair(coarse()), penalty_pair(coarse())})
    settings.insert(settings.end(), pair.begin(), pair.end());
  runs_.make(std::move(settings));
  largest_ = largest(runs_.of(at(finest)), study_.request.of);
  if (!requested_) requested_ = study_.request.error * largest_;
  piloted_ = true;

  reachable_ = *requested_;
  if (exact_time_ && !penalised_) return;
  leave_fine_settings();
  const double before = chosen_.fineness;
  if (!stepping_ && !exact_time_) {
    const Part found = time_error(coarse());
    pilot_error_ = found.error;
    refine_time(found);
    looser_ = std::max(1.0, before / chosen_.fineness);
  }
  constexpr double sure = 1e-12;  // finer tolerances may not bring what they promise
  if (!stepping_ && !penalised_ && !given.tolerance && chosen_.fineness > sure) return;
  settle(coarse());
  reachable_ = std::max(reachable_, time_error(coarse()).error + penalty_error(coarse()).error);
}

bool Plan::affordable(std::size_t elements) const {
  const Setup setup = resolve(with(at(elements)));
  return elements <= study_.most_elements && estimated_seconds(setup) <= 10.0 * study_.most_seconds &&
         faults(setup).empty();
}

// In eights, so that a half has quarters, and halves keep the unit.
std::size_t Plan::multiple(std::size_t elements) const {
  const std::size_t of = std::lcm(std::size_t{8}, 2 * unit_);
  return (elements + of - 1) / of * of;
}

// J (e / wanted)^(1/p). Up to 256, where a run costs about as much on half as many elements, in doubled units, so that
// the runs of the pilots serve.
std::size_t Plan::wanted_elements(const SpaceError& known, std::size_t from) const {
  constexpr double few = 256.0, longest = 4.0;  // the meshes between are run for the estimate anyway
  if (known.error <= 0.0) return doubled_unit(least_elements);
  const double order = std::clamp(known.order, 0.5, theory_);
  const double factor = std::pow(known.error / (shares_.space * reachable_), 1.0 / order);
  const double elements = std::ceil(static_cast<double>(from) * std::min(factor, longest));
  const auto wanted = static_cast<std::size_t>(elements);
  return elements <= few || doubled_ ? doubled_unit(std::max(wanted, least_elements)) : multiple(wanted);
}

// Meshes are refined until the last one before the solution's promises that the solution keeps the request. Of order 2,
// as on a span obstacle whose border moves from node to node, only a halved mesh is far enough to tell.
void Plan::climb() {
  std::size_t best = chosen_.elements;
  const Setting first = chosen_;
  runs_.most_seconds = study_.most_seconds;
  try {
    climb_from(best);
  } catch (const TooLong&) {
    chosen_ = first;
    doubt_ = fmt::format("meshes of more than {} elements take longer than {:.3g} s to try, and that one is too coarse",
                         best, study_.most_seconds);
  }
  if (!doubt_.empty()) {
    chosen_.elements = best;
    doubt_ += fmt::format("; the solution is the best that was reached, on {} elements", best);
  }
  runs_.most_seconds = RunLimits().seconds;
  looser_ = 1.0;
}

// `best`: the mesh of the least error by four meshes, or the finest that has been run.
void Plan::climb_from(std::size_t& best) {
  constexpr int most_rounds = 14;
  std::size_t known = chosen_.elements;
  const double share = shares_.space;
  double least = std::numeric_limits<double>::infinity();
  double before = 0.0;
  int stuck = 0;
  for (int round = 0; round < most_rounds; ++round) {
    bool same = true;
    std::vector<MeshStep> steps = made_ladder(known, 2, &same);
    // A third mesh shows an order. It is run where that of theory would keep the request.
    if (steps.size() == 1 && seen_error(prolonged(steps, 2 * known, theory_)).error <= share * reachable_)
      steps = made_ladder(known, 3, &same);
    const SpaceError now = seen_error(steps);
    const bool seen = same && steps.size() + 1 == most_rungs;
    if (seen ? now.error <= least : std::isinf(least)) best = known;
    if (seen) least = std::min(least, now.error);
    std::size_t next = same ? wanted_elements(now, known) : 2 * known;
    if (now.error <= share * reachable_ && same && next <= known) {
      chosen_.elements = next < known && begun_ ? known / 2 : known;  // the neighbour's mesh was far finer than needed
      return;
    }
    const double expected = expected_order(steps, theory_);
    for (std::size_t quarters = theory_ > 2.0 && !doubled_ ? 5 : 8; same && quarters <= 8; ++quarters) {
      const std::size_t solution = known * quarters / 4;
      if (known * quarters % (4 * unit_) != 0 || solution < least_elements ||
          seen_error(prolonged(steps, solution, expected)).error > 1.05 * share * reachable_)
        continue;
      chosen_.elements = solution;
      return;
    }
    next = std::max(next, 2 * known);
    const double apart = steps.empty() ? 0.0 : steps.back().distance;
    // Meshes that are too coarse for the waves of a load do not come nearer to each other.
    const std::size_t telling = apart_ ? 2048 : 512;  // elements that show how a scene converges
    const bool sees = data_error_.sees(known) && (!apart_ || known >= telling);
    stuck = before > 0.0 && apart > 0.9 * before && sees ? stuck + 1 : 0;
    before = apart;
    if (stuck >= 3) {
      doubt_ = fmt::format(
          "no mesh converges: runs on {} and {} elements are {:.2g} apart, no less than coarser ones; the scene "
          "multiplies a small change of its initial data by {:.2g}",
          steps.back().coarse, steps.back().fine, apart, magnification());
      return;
    }
    const double order = std::clamp(now.order, 0.5, theory_);
    const double wanted = static_cast<double>(known) * std::pow(now.error / (share * reachable_), 1.0 / order);
    if (!affordable(next)) next = 2 * known;
    if (!affordable(next)) {
      doubt_ = fmt::format(
          "about {:.2g} elements would keep the error that was asked for, and {} are the most that "
          "are tried: the error falls with the power {:.2g} of the mesh here; the scene multiplies a "
          "small change of its initial data by {:.2g}",
          wanted, study_.most_elements, now.order, magnification());
      return;
    }
    if (stepping_ || penalised_) settle(with_enough(std::max<std::size_t>(next / 4, 8)));
    known = next >= 3 * known ? next / 2 : 2 * known;
  }
  doubt_ = "no mesh was found that keeps the error that was asked for";
}

}  // namespace viscobar::accuracy
