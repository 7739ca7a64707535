// Errors by the settings in time and penalty, and the settings that keep their share of the error.
#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/natural_scales.hpp"
#include "studies/accuracy/plan.hpp"
#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar::accuracy {

namespace {

constexpr double finest_tolerance = 1e-13, loosest_that_methods_take = 0.1;
// Usual error of the methods, as a share of the relative tolerance (docs/accuracy-on-request.md). It bounds estimates
// from below, for two runs may be closer to each other than to the motion.
constexpr double usual_error = 0.005;
constexpr double least_order_of_penalty = 0.5, penalty_ratio = 10.0;

double error_of(double apart, double ratio, double order) {
  const double share = std::pow(ratio, -order);
  return apart * share / (1.0 - share);
}

// Makes a setting finer whose error, a power of it, is more than its share; true if that is another one.
bool refine(double& setting, const Part& part, double share, double at_once, double least) {
  if (part.error <= excess * share) return false;
  const double finer =
      std::max(least, setting * std::clamp(std::pow(share / part.error, 1.0 / part.order), at_once, 0.5));
  return finer < std::exchange(setting, std::min(finer, setting));
}

}  // namespace

// By the two finest of the runs that differ in one number alone; three of them may show a power above `least`.
Part Plan::part_of(const Setting& finest, double Setting::*number, double least, double most) const {
  std::vector<Setting> runs;
  for (const Setting& known : runs_.known()) {
    Setting alike = known;
    alike.*number = finest.*number;
    if (alike == finest && known >= finest) runs.push_back(known);
  }
  Part part{0.0, least};
  if (runs.size() < 2) return part;
  const auto ratio = [&](std::size_t k) { return runs[k + 1].*number / (runs[k].*number); };
  const double found = apart(runs[0], runs[1]);
  if (runs.size() >= 3 && least < most)
    if (const auto order = power_of_changes(ratio(1), ratio(0), apart(runs[1], runs[2]), found))
      part.order = std::clamp(*order, least, most);
  part.error = error_of(found, ratio(0), part.order);
  return part;
}

// Two that tell the error of the chosen tolerance, or step, on a mesh.
std::vector<Setting> Plan::time_pair(std::size_t elements) const {
  if (exact_time_ || waves_) return {};
  Setting other = at(elements);
  other.fineness *= ratio_;
  if (!stepping_ && other.fineness > loosest_that_methods_take) other.fineness = chosen_.fineness / ratio_;
  return {at(elements), other};
}

Part Plan::time_error(std::size_t elements) {
  const std::vector<Setting> pair = time_pair(elements);
  if (pair.empty()) return {};
  runs_.make(pair);
  if (stepping_) {
    // A node stops within a step, in which a line lies beside the kink: between any two times. A contact changes at
    // the end of a step, which two steps may have in common.
    Part part = part_of(pair[0], &Setting::fineness, time_order_, 2.0);
    const Goal of = study_.request.of;
    if (of == Goal::displacement || of == Goal::end_traces)
      part.error = std::max(part.error, 0.25 * closing_speed_ * chosen_.fineness);
    if (of == Goal::contact_times && !runs_.of(pair[0]).events.empty())
      part.error = std::max(part.error, chosen_.fineness);
    return part;
  }
  Part part{apart(pair[0], pair[1]) / (1.0 - std::pow(ratio_, -time_order_)), time_order_};
  if (pair[1].fineness > pair[0].fineness) part = part_of(pair[0], &Setting::fineness, time_order_, time_order_);
  part.error = std::max(part.error, usual_error * chosen_.fineness * largest_);
  return part;
}

// A penalty that was chosen is beside a softer one. One that the scene gives may be soft already, and a softer one then
// wrong by no more: a harder one tells. Springs of a span obstacle are one a node, and harder together on a finer mesh.
// One of them stops its node within (rho epsilon)^(1/2). While that is longer than from the touch of a node to that of
// its neighbour, they stop together, and the error hardly changes with epsilon: a tenth of it tells nothing, a
// thousandth stops them 30 times sooner.
std::vector<Setting> Plan::penalty_pair(std::size_t elements) const {
  const bool given = study_.request.given.epsilon;
  // The peak of a stop that gives way is that of its spring.
  if (!penalised_ || (given && study_.request.of == Goal::peak_reaction)) return {};
  const Setting own = at(given && base_.scene.span ? chosen_.elements : elements);
  Setting other = own;
  other.epsilon *= !given ? penalty_ratio : 1.0 / (base_.scene.span ? std::pow(penalty_ratio, 3) : penalty_ratio);
  return {own, other};
}

Part Plan::penalty_error(std::size_t elements) {
  const std::vector<Setting> pair = penalty_pair(elements);
  if (pair.empty()) return {};
  runs_.make(pair);
  const bool softer = pair[1].epsilon > pair[0].epsilon;
  Part part = part_of(pair[softer ? 0 : 1], &Setting::epsilon, least_order_of_penalty, 1.0);
  if (!softer) part.error *= std::pow(pair[0].epsilon / pair[1].epsilon, part.order);
  // How deep a node is in an obstacle is an error of it, soon after an impact and between any two times.
  const Goal of = study_.request.of;
  const Setting& own = runs_.knows(chosen_) ? chosen_ : pair[0];
  if (of == Goal::displacement || of == Goal::end_traces) part.error = std::max(part.error, penetration(own));
  return part;
}

// Largest depth of a node in an obstacle of the penalty. Where there are stops with laws of their own, whose depth is
// no error, it is that of the springs of the others, epsilon R.
double Plan::penetration(const Setting& of) {
  const Scene& scene = base_.scene;
  const Statistics& run = runs_.of(of).statistics;
  if (!has_stops(scene) || scene.span || !run.account) return run.max_penetration;
  double reaction = 0.0;
  if (!scene.left_input.stop) reaction = std::max(reaction, run.account->left.peak_reaction);
  if (!scene.right_input.stop) reaction = std::max(reaction, run.account->right.peak_reaction);
  for (std::size_t k = 0; k < run.account->joints.size(); ++k)
    if (!scene.chain[k].joint.stop) reaction = std::max(reaction, run.account->joints[k].peak_reaction);
  return std::min(run.max_penetration, of.epsilon * reaction);
}

bool Plan::refine_time(const Part& part) {
  const bool given = stepping_ ? study_.request.given.step : study_.request.given.tolerance;
  if (given || exact_time_ || waves_) return false;
  if (stepping_) return refine(chosen_.fineness, part, shares_.time * *requested_, 1.0 / 16.0, 0.0);
  return refine(chosen_.fineness, {part.error, 0.9}, shares_.time * *requested_, 1e-5, finest_tolerance);
}

bool Plan::refine_penalty(const Part& part) {
  if (!penalised_ || study_.request.given.epsilon) return false;
  return refine(chosen_.epsilon, part, shares_.penalty * *requested_, 1e-4, 1e-16 * natural_epsilon(base_.scene));
}

void Plan::settle(std::size_t elements) {
  constexpr int most_rounds = 6;
  for (int k = 0; k < most_rounds && refine_time(time_error(elements)); ++k) continue;
  for (int k = 0; k < most_rounds && refine_penalty(penalty_error(elements)); ++k) continue;
}

}  // namespace viscobar::accuracy
