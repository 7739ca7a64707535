#pragma once

#include "support/verdict_scenes.hpp"

namespace viscobar {

/// What is known of a scene without a limit study: the verdict by theory, and |P(0) - S(0)| by other runs.
struct KnownVerdict {
  Verdict verdict = Verdict::undecided;
  bool touches = false;
  std::optional<double> distance;  ///< |P(0) - S(0)|; absent: no other run tells
  double error = 0.0;              ///< its change from a step of the scheme to one three times smaller
};

/// Whether an end stands on its obstacle at the start.
inline bool begins_in_contact(const Case& run) {
  const auto at = [&](const EndCondition& end, double x) {
    const auto* obstacle = std::get_if<Obstacle>(&end);
    return obstacle && run.scene.displacement(x) + obstacle->gap <= 0.0;
  };
  return at(run.scene.left, 0.0) || at(run.scene.right, run.scene.bar.length);
}

/// S(0) is taken from steps much smaller than a study's. P(0) is the rigid limit of massless nodes. End nodes with mass
/// on an undamped penalty tend to the scheme of restitution 1, so that no penalised run is needed, but not where the
/// bar begins in contact: the first step of the scheme knows no impact. Other nodes with mass are run at
/// epsilon = 1e-10 by matrix exponentials, on more than 100 elements at 1e-9 by cvode.
inline KnownVerdict known_verdict(const VerdictScene& scene) {
  Case run = scene.run;
  run.tolerance = {1e-10, 1e-13};
  run.output_every = run.end;
  run.method = MethodName::fully_discrete;
  run.step = run.end / std::min(2e5, 1e8 / static_cast<double>(run.elements));
  Case limit = run;
  const bool massless = run.mass == Mass::redistributed,
             by_scheme = !massless && !run.restitution && !run.scene.span && !begins_in_contact(run);
  if (massless) {
    limit.method = MethodName::rigid;
  } else if (by_scheme) {
    limit.restitution = 1.0;
  } else {
    limit.method = run.elements <= 100 ? MethodName::exponential : MethodName::cvode;
    limit.epsilon = run.elements <= 100 ? 1e-10 : 1e-9;
  }
  KnownVerdict known;
  if (run.scene.span && run.elements > 100) {  // takes an hour
    known.touches = !contact_changes(run).empty();
    known.verdict = verdict_by_theory(run, known.touches, scene.pressed);
    return known;
  }
  const std::vector<double> times = comparison_times(run.end, 2000, contact_changes(limit));
  std::vector<double> distances;
  EndTraces exact = trace_ends(limit, times);
  for (const double step : {*run.step * std::sqrt(10.0), *run.step}) {
    limit.step = run.step = step;
    if (by_scheme) exact = trace_ends(limit, times);
    const EndTraces scheme = trace_ends(run, times);
    known.touches = !scheme.events.empty();
    distances.push_back(largest_difference(exact, scheme));
  }
  known.distance = distances[1];
  known.error = std::abs(distances[0] - distances[1]);
  known.verdict = verdict_by_theory(run, known.touches, scene.pressed);
  return known;
}

/// Whether the bounds of a study enclose the distance; those of the beginning of a run say nothing about its rest but
/// that limits which differ do so there.
inline bool agrees(const LimitEvidence& evidence, const KnownVerdict& known) {
  const auto lower = evidence.lower(), upper = evidence.upper();
  if (!known.distance || !lower || !upper) return true;
  if (evidence.until) return *lower <= *known.distance + known.error;
  return *lower <= *known.distance + known.error && *upper >= *known.distance - known.error;
}

}  // namespace viscobar
