#include "viscobar/analysis/work_precision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "analysis/precision/field.hpp"
#include "analysis/precision/reference.hpp"
#include "analysis/precision/timing.hpp"
#include "viscobar/analysis/parallel.hpp"

namespace viscobar {

namespace {

using namespace precision;

// References may take this many times as long as a timed run: they are made once.
constexpr double patience = 20.0;
constexpr double decade = 10.0;

/// Errors are taken at the scene's output times, or at every n-th where their fields would fill the memory.
double error_times(const Case& scene, const std::vector<Mesh>& meshes) {
  constexpr double most_times = 2000.0, most_entries = 4e6;
  std::size_t nodes = 0;
  for (const Mesh& mesh : meshes) nodes = std::max(nodes, mesh.nodes());
  const double most = std::clamp(most_entries / static_cast<double>(nodes), 50.0, most_times);
  return scene.output_every * std::max(1.0, std::ceil(scene.end / scene.output_every / most));
}

/// Why the method does not fit the scene; its step is the study's to choose.
std::optional<std::string> misfit(Case run) {
  if (is_scheme(run.method)) run.step = run.mesh().spacing();
  const std::vector<Finding> findings = validate(run);
  if (findings.empty()) return std::nullopt;
  return fmt::format("{}: {}", findings.front().key, findings.front().problem);
}

std::vector<Timed> timed_rows(const PrecisionStudy& study, const Case& scene, const std::vector<Mesh>& meshes,
                              std::vector<PrecisionResult::LeftOut>& left_out) {
  std::vector<MethodName> methods = study.methods;
  if (methods.empty())
    std::copy_if(std::begin(all_methods), std::end(all_methods), std::back_inserter(methods),
                 [](MethodName method) { return is_scheme(method) || is_adaptive(method); });
  std::vector<Timed> all;
  for (const Mesh& mesh : meshes)
    for (const MethodName method : methods) {
      Case run = scene;
      run.elements = mesh.elements;
      run.method = method;
      if (const auto reason = misfit(run)) {
        if (!study.methods.empty())
          throw std::invalid_argument(fmt::format("{} does not fit the scene: {}", name(method), *reason));
        left_out.push_back({method, mesh.elements, "", *reason});
        continue;
      }
      std::vector<Timed> rows = settings_of(study, run);
      time_rows(study, rows, left_out);
      std::move(rows.begin(), rows.end(), std::back_inserter(all));
    }
  return all;
}

/// The semi-discrete problems that a system's errors take: itself, and for a penalty what it tends to.
struct Chain {
  System own;
  std::optional<System> softer;  ///< epsilon / 10
  std::optional<System> limit;   ///< epsilon = 0, or / 100
};

Chain chain_of(const System& own) {
  if (own.epsilon == 0.0) return {own, std::nullopt, std::nullopt};
  System next = own, limit = own;
  next.epsilon /= decade;
  limit.epsilon /= decade * decade;
  if (own.mass == Mass::redistributed) limit = {own.elements, own.mass, System::Law::rigid, 0.0};
  return {own, next, limit};
}

class Study {
 public:
  explicit Study(const PrecisionStudy& study) : study_(study), scene_(study.scene) {
    std::vector<std::size_t> elements = study.elements;
    if (elements.empty()) elements = {scene_.elements};
    for (const std::size_t count : elements) meshes_.push_back({scene_.scene.bar.length, count});
    scene_.output_every = error_times(scene_, meshes_);
    result_.times = static_cast<double>(scene_.output_times().size());
    result_.every = scene_.output_every;
  }

  PrecisionResult operator()() {
    timed_ = timed_rows(study_, scene_, meshes_, result_.left_out);
    if (timed_.empty()) throw std::invalid_argument(nothing_to_run());
    for (Timed& timed : timed_) timed.run.output_every = scene_.output_every;
    find_references();
    measure_errors();
    for (Timed& timed : timed_) result_.rows.push_back(std::move(timed.row));
    result_.reference = std::move(continuous_.reference);
    result_.no_reference = std::move(continuous_.problem);
    return std::move(result_);
  }

 private:
  std::string nothing_to_run() const {
    std::string text = "no method has a run to show";
    for (const auto& [method, elements, what, reason] : result_.left_out)
      text += fmt::format("\n  {} on {} elements: {}", name(method), elements, reason);
    return text;
  }

  void find_references() {
    constexpr double unset = std::numeric_limits<double>::infinity();
    std::map<System, Fineness> finest;
    for (const Timed& timed : timed_) {
      if (!timed.row.failure.empty()) continue;
      Fineness& fineness = finest.try_emplace(system_of(timed.run), Fineness{unset, unset}).first->second;
      if (is_adaptive(timed.row.method)) fineness.tolerance = std::min(fineness.tolerance, timed.row.setting / decade);
      if (is_scheme(timed.row.method)) fineness.step = std::min(fineness.step, timed.row.setting / 4.0);
    }
    for (auto& [system, fineness] : finest)
      if (fineness.tolerance == unset) fineness.tolerance = Fineness{}.tolerance;
    for (const auto& [system, fineness] : std::map(finest)) {
      const Chain chain = chain_of(system);
      if (chain.softer) finest.try_emplace(*chain.softer, fineness);
      if (chain.limit) finest.try_emplace(*chain.limit, fineness);
    }
    std::vector<std::pair<System, Fineness>> jobs(finest.begin(), finest.end());
    std::vector<SemiDiscrete> found(jobs.size());
    if (study_.progress) study_.progress("references");
    const double seconds = patience * study_.seconds;
    // The longest of them, refinement of the mesh, begins first.
    parallel_for(
        jobs.size() + 1,
        [&](std::size_t i) {
          if (i == 0)
            solve_continuous(seconds);
          else
            found[i - 1] = solve_in_time(scene_, jobs[i - 1].first, jobs[i - 1].second, seconds);
        },
        study_.threads);
    for (std::size_t i = 0; i < jobs.size(); ++i) solved_.emplace(jobs[i].first, std::move(found[i]));
  }

  void solve_continuous(double seconds) {
    const auto known = study_.exact ? study_.exact : known_solution(scene_.scene, scene_.end);
    continuous_ = known ? closed_form(*known, scene_, meshes_) : refine(scene_, meshes_, seconds);
  }

  const Field* exact_on(std::size_t elements) const {
    for (const Field& field : continuous_.fields)
      if (field.mesh.elements == elements) return &field;
    return nullptr;
  }

  const Field* field_of_system(const std::optional<System>& system) const {
    const auto found = system ? solved_.find(*system) : solved_.end();
    return found != solved_.end() && found->second.field ? &*found->second.field : nullptr;
  }

  ErrorParts parts_of(const Timed& timed) const {
    ErrorParts parts;
    parts.method = timed.row.method;
    parts.elements = timed.row.elements;
    parts.mass = timed.row.mass;
    const Chain chain = chain_of(system_of(timed.run));
    const auto found = solved_.find(chain.own);
    if (found == solved_.end()) {
      parts.problem = "every run failed";
      return parts;
    }
    const SemiDiscrete& own = found->second;
    parts.problem = own.problem;
    if (!own.field) return parts;
    parts.time_reference = own.what;
    parts.time_reference_error = own.error;
    const Field* limit = chain.limit ? field_of_system(chain.limit) : &*own.field;
    const Field* softer = field_of_system(chain.softer);
    const Field* exact = exact_on(parts.elements);
    if (limit && exact) parts.space = distance(*limit, *exact);
    if (!chain.limit || !limit) return parts;
    parts.penalty = distance(*own.field, *limit);
    parts.penalty_against = solved_.at(*chain.limit).what;
    if (chain.limit->law == System::Law::penalised)
      parts.penalty_against = fmt::format("epsilon / 100 by {}", parts.penalty_against);
    if (!softer) return parts;
    // To the limit itself the power is that of the differences; to epsilon / 100, that of the steps towards it.
    const bool to_limit = chain.limit->law == System::Law::rigid;
    const double here = to_limit ? *parts.penalty : distance(*own.field, *softer);
    const double there = distance(*softer, *limit);
    if (here > 3.0 * own.error && there > 3.0 * own.error) parts.penalty_order = std::log10(here / there);
    return parts;
  }

  void measure_errors() {
    for (const Timed& timed : timed_)
      if (result_.parts.empty() || result_.parts.back().method != timed.row.method ||
          result_.parts.back().elements != timed.row.elements)
        result_.parts.push_back(parts_of(timed));
    if (study_.progress) study_.progress("errors");
    parallel_for(
        timed_.size(), [&](std::size_t i) { measure(timed_[i]); }, study_.threads);
  }

  void measure(Timed& timed) const {
    PrecisionRow& row = timed.row;
    if (!row.failure.empty()) return;
    const Field* exact = exact_on(row.elements);
    const Field* own = field_of_system(system_of(timed.run));
    double error = 0.0, time_error = 0.0;
    std::size_t k = 0;
    Observers observers;
    observers.snapshot = [&](const Snapshot& now) {
      if (exact) error = std::max(error, distance(now.u, exact->at(k)));
      if (own) time_error = std::max(time_error, distance(now.u, own->at(k)));
      ++k;
    };
    try {
      simulate(timed.run, make_system(timed.run), observers);
      if (exact) row.error = error;
      if (own) row.time_error = time_error;
    } catch (const std::exception& failure) {
      row.failure = failure.what();
    }
  }

  const PrecisionStudy& study_;
  Case scene_;
  std::vector<Mesh> meshes_;
  std::vector<Timed> timed_;
  std::map<System, SemiDiscrete> solved_;
  Continuous continuous_;
  PrecisionResult result_;
};

}  // namespace

const ErrorParts& PrecisionResult::parts_of(const PrecisionRow& row) const {
  return *std::find_if(parts.begin(), parts.end(), [&](const ErrorParts& candidate) {
    return candidate.method == row.method && candidate.elements == row.elements;
  });
}

PrecisionResult work_precision(const PrecisionStudy& study) { return Study(study)(); }

}  // namespace viscobar
