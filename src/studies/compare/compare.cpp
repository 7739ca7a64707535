#include "viscobar/studies/compare/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "case/alarm.hpp"
#include "studies/parallel.hpp"
#include "studies/run_limits.hpp"
#include "viscobar/case/recorder.hpp"
#include "viscobar/integration/integrate.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar {

namespace {

// Steps times nodes of an explicit method, some ten seconds of them.
constexpr double most_explicit_work = 5e8;

/// Takes the method in, or says why it does not fit.
std::optional<std::string> try_method(MethodChoice& choice, const Case& scene, MethodName method) {
  Case run = scene;
  run.method = method;
  if (!run.mass) run.mass = common_mass(scene);
  const bool needs_step = is_scheme(method) && !run.step;
  if (needs_step) run.step = resolve(run).step;
  auto reason = fault_in_words(resolve(run));
  if (reason && !scene.mass) {
    run.mass.reset();
    reason = fault_in_words(resolve(run));
  }
  if (reason) return reason;
  if (needs_step) choice.default_step.push_back(method);
  choice.cases.push_back(std::move(run));
  return std::nullopt;
}

std::optional<std::string> takes_long(const Case& scene, MethodName method) {
  Case run = scene;
  run.method = method;
  if (method != MethodName::odeint) return std::nullopt;
  const Setup setup = resolve(std::move(run));
  if (!faults(setup).empty()) return std::nullopt;
  const double steps = plan(setup.system(), scene.end, std::get<Odeint>(setup.method)).least_steps;
  if (steps * static_cast<double>(scene.elements) <= most_explicit_work) return std::nullopt;
  return fmt::format("would make {:.1e} steps, for it is explicit; it runs when asked for by name", steps);
}

MethodRun attempt(const Contender& contender) {
  Case run = contender.run;
  run.directions.clear();  // methods are compared by quantities that all of them have
  MethodRun result{contender.label, !contender.solver, resolve(std::move(run)), {}, {}, {}, 0};
  try {
    Recording recording = result.built_in ? record_setup(result.setup) : contender.solver(result.setup.run);
    auto problem = fault(recording, result.setup.run);
    if (!problem) problem = overflow(recording.statistics);
    if (problem) throw std::invalid_argument(*problem);
    result.recording = std::move(recording);
  } catch (const std::exception& error) {
    result.error = error.what();
  }
  return result;
}

}  // namespace

MethodChoice fitting_methods(const Case& scene) {
  MethodChoice choice;
  std::vector<MethodName> methods(std::begin(all_methods), std::end(all_methods));
  std::stable_partition(methods.begin(), methods.end(), [](MethodName m) { return m == MethodName::exponential; });
  for (const MethodName method : methods) {
    if (method == MethodName::exponential && scene.elements > most_exponential_elements &&
        scene.elements < Exponential::most_unknowns)
      choice.skipped.push_back(
          {method, fmt::format("takes long on {} elements; it runs when asked for by name", scene.elements)});
    else if (auto slow = takes_long(scene, method))
      choice.skipped.push_back({method, std::move(*slow)});
    else if (auto reason = try_method(choice, scene, method))
      choice.skipped.push_back({method, std::move(*reason)});
  }
  // The reference is the first: the exact solution of the bar, else of its penalised mesh.
  std::stable_partition(choice.cases.begin(), choice.cases.end(),
                        [](const Case& run) { return run.method == MethodName::characteristics; });
  return choice;
}

MethodChoice chosen_methods(const Case& scene, std::span<const MethodName> methods) {
  MethodChoice choice;
  for (auto method = methods.begin(); method != methods.end(); ++method) {
    if (std::find(methods.begin(), method, *method) != method)
      throw std::invalid_argument(fmt::format("{} is asked for twice", name(*method)));
    if (const auto reason = try_method(choice, scene, *method))
      throw std::invalid_argument(fmt::format("{} does not fit the scene: {}", name(*method), *reason));
  }
  return choice;
}

const Difference* Comparison::to_reference(std::size_t run) const {
  for (const Pair& pair : pairs)
    if (pair.first == reference && pair.other == run) return &pair.difference;
  return nullptr;
}

bool Comparison::completed() const {
  return std::all_of(runs.begin(), runs.end(), [](const MethodRun& run) { return run.recording.has_value(); });
}

Comparison compare(std::span<const Case> cases, std::size_t threads) {
  std::vector<Contender> contenders;
  for (const Case& run : cases) contenders.push_back({std::string(name(run.method)), run, {}});
  return compare(contenders, threads);
}

Comparison compare(std::span<const Contender> contenders, std::size_t threads) {
  std::vector<MethodRun> runs(contenders.size());
  parallel_for(
      runs.size(), [&](std::size_t i) { runs[i] = attempt(contenders[i]); }, threads);
  return compare(std::move(runs));
}

Comparison compare(std::vector<MethodRun> runs) {
  const std::size_t count = runs.size();
  Comparison result;
  result.runs = std::move(runs);
  for (std::size_t i = 0; i < count; ++i) {
    MethodRun& run = result.runs[i];
    run.index = i;
    if (!run.recording) continue;
    const std::vector<double>& times = run.recording->times;
    run.contacts = contact_periods(*run.recording, 0.01 * (times.back() - times.front()));
    if (!result.reference) result.reference = i;
    for (std::size_t j = i + 1; j < count; ++j) {
      const MethodRun &first = result.runs[i], &other = result.runs[j];
      if (!other.recording) continue;
      result.pairs.push_back({i, j, compare(*first.recording, *other.recording)});
    }
  }
  return result;
}

}  // namespace viscobar
