#include "viscobar/studies/compare/examine.hpp"

#include <fmt/format.h>

#include <cmath>

namespace viscobar {

namespace {

std::vector<Contender> contenders(const std::string& label, const Solver& scheme, const Trial& trial) {
  std::vector<Contender> list;
  if (trial.solution) list.push_back({"exact", trial.run, exact::solver(*trial.solution)});
  if (!trial.methods.empty() || !trial.solution) {
    const MethodChoice choice =
        trial.methods.empty() ? fitting_methods(trial.run) : chosen_methods(trial.run, trial.methods);
    for (const Case& run : choice.cases) list.push_back({std::string(name(run.method)), run, {}});
  }
  list.push_back({label, trial.run, scheme});
  return list;
}

void judge(const Bounds& bounds, const Difference& found, const std::string& reference,
           std::vector<Finding>& findings) {
  const auto hold = [&](const char* quantity, std::optional<double> value, std::optional<double> bound) {
    if (!bound) return;
    const std::string key = fmt::format("{}: {}", reference, quantity);
    if (!value)
      findings.push_back({key, fmt::format("is not known, {:.3g} is the bound", *bound)});
    else if (!(*value <= *bound))
      findings.push_back({key, fmt::format("{:.3g} exceeds {:.3g}", *value, *bound)});
  };
  hold("displacement, L2", found.displacement_l2, bounds.displacement_l2);
  hold("displacement, H1", found.displacement_h1, bounds.displacement_h1);
  hold("velocity, L2", found.velocity_l2, bounds.velocity_l2);
  hold("end trace", found.end_trace, bounds.end_trace);
  for (const auto& [a, b] : found.contacts)
    if (a.where != Where::span)
      hold("impulse", a.impulse && b.impulse ? std::optional(std::abs(*a.impulse - *b.impulse)) : std::nullopt,
           bounds.impulse);
  if (!bounds.event_shift) return;
  if (found.events_matched != found.events || found.events_matched != found.events_other)
    findings.push_back(
        {reference + ": contact changes", fmt::format("{} of the reference's {} and the scheme's {} match",
                                                      found.events_matched, found.events, found.events_other)});
  hold("time of a contact change", found.largest_event_shift.value_or(0.0), bounds.event_shift);
}

TrialResult one(const std::string& label, const Solver& scheme, const Trial& trial, std::size_t threads) {
  TrialResult result;
  result.name = trial.name;
  result.check = compare(contenders(label, scheme, trial), threads);
  const std::vector<MethodRun>& runs = result.check.runs;
  for (const MethodRun& run : runs)
    if (!run.recording) result.findings.push_back({run.label, "failed: " + run.error});
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
    const Difference* difference = result.to(i);
    if (!difference) continue;
    Bounds bounds = trial.bounds;
    if (runs[i].label == "exact") bounds.event_shift.reset();  // an exact solution lists no changes
    judge(bounds, *difference, runs[i].label, result.findings);
  }
  if (trial.solution && result.scheme().recording &&
      result.scheme().recording->mesh.elements_of_bars() == trial.run.elements)
    result.error = exact::error(*result.scheme().recording, *trial.solution);
  return result;
}

}  // namespace

const Difference* TrialResult::to(std::size_t reference) const {
  for (const Comparison::Pair& pair : check.pairs)
    if (pair.first == reference && pair.other + 1 == check.runs.size()) return &pair.difference;
  return nullptr;
}

std::vector<TrialResult> examine(const std::string& label, const Solver& scheme, std::span<const Trial> trials,
                                 std::size_t threads) {
  std::vector<TrialResult> results;
  for (const Trial& trial : trials) results.push_back(one(label, scheme, trial, threads));
  return results;
}

}  // namespace viscobar
