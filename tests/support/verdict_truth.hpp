#pragma once

#include "support/verdict_scenes.hpp"

namespace viscobar {

/// Truth about a scene without a limit study: the verdict by theory, and |P(0) - S(0)| by other runs.
struct KnownVerdict {
  Verdict verdict = Verdict::undecided;
  bool touches = false;
  std::optional<double> distance;  ///< |P(0) - S(0)|; absent: no other run tells
  double error = 0.0;              ///< of it, by a step three times longer and 10 epsilon
};

/// S(0) is taken from steps much smaller than a study's. P(0) is the rigid limit of massless nodes. Nodes with mass are
/// run at epsilon = 1e-10 min(1, L/E) by matrix exponentials, on more than 100 elements at 1e-9 by cvode: the scheme of
/// restitution 1 would need steps of a thousandth of the first bounce.
inline KnownVerdict known_verdict(const VerdictScene& scene) {
  Case run = scene.run;
  run.tolerance = {1e-10, 1e-13};
  run.output_every = run.end;
  run.method = MethodName::fully_discrete;
  run.step = run.end / std::min(2e5, 1e8 / static_cast<double>(run.elements));
  Case limit = run;
  if (run.mass == Mass::redistributed) {
    limit.method = MethodName::rigid;
  } else {
    limit.method = run.elements <= 100 ? MethodName::exponential : MethodName::cvode;
    limit.epsilon = (run.elements <= 100 ? 1e-10 : 1e-9) * std::min(1.0, run.scene.bar.length / run.scene.bar.modulus);
  }
  KnownVerdict known;
  if (run.scene.span && run.elements > 100) {  // takes an hour
    known.touches = !contact_changes(run).empty();
    known.verdict = verdict_by_theory(run, known.touches, scene.pressed);
    return known;
  }
  const std::vector<double> times = comparison_times(run.end, 2000, contact_changes(limit));
  const EndTraces exact = trace_ends(limit, times);
  const double refinement = std::sqrt(10.0);
  Case longer = run;
  *longer.step *= refinement;
  const EndTraces scheme = trace_ends(run, times);
  known.touches = !scheme.events.empty();
  known.distance = largest_difference(exact, scheme);
  // A contact closes up to a step late: two steps show half of the error's constant or more.
  known.error = 2.0 * largest_difference(scheme, trace_ends(longer, times)) / (refinement - 1.0);
  if (run.mass != Mass::redistributed) {
    *limit.epsilon *= 10.0;
    known.error += largest_difference(exact, trace_ends(limit, times));
  }
  known.verdict = verdict_by_theory(run, known.touches, scene.pressed);
  return known;
}

/// True if the bounds of a study enclose the distance; those of the beginning of a run say nothing about its rest but
/// that limits which differ do so there.
inline bool agrees(const LimitEvidence& evidence, const KnownVerdict& known) {
  const auto lower = evidence.lower(), upper = evidence.upper();
  if (!known.distance || !lower || !upper) return true;
  if (evidence.until) return *lower <= *known.distance + known.error;
  return *lower <= *known.distance + known.error && *upper >= *known.distance - known.error;
}

}  // namespace viscobar
