#include "studies/accuracy/quick_estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "run/stopwatch.hpp"
#include "studies/accuracy/plan.hpp"

namespace viscobar::accuracy {

namespace {

constexpr std::size_t fewest = 9;  // elements of a mesh that can be halved twice
constexpr double least_seconds = 0.5;

}  // namespace

QuickEstimate quick_estimate(const Case& run, std::optional<Sample> solution, double seconds,
                             const std::function<bool()>& stop) try {
  QuickEstimate result;
  result.elements = run.elements;
  if (fewest_in_a_bar(run) < fewest && run.method != MethodName::characteristics) {
    result.why_not = fmt::format("it needs {} elements or more{}, whose mesh can be halved twice", fewest,
                                 run.scene.chain.empty() ? "" : " in each bar");
    return result;
  }
  Plan plan(run, std::max(seconds, least_seconds), stop);
  plan.next();
  result.estimate = plan.judge(std::move(solution));
  return result;
} catch (const StudyStopped&) {
  return {std::nullopt, "it was interrupted", run.elements};
} catch (const TooLong&) {
  return {std::nullopt, fmt::format("its runs take longer than {:.2g} s", std::max(seconds, least_seconds)),
          run.elements};
} catch (const IntegrationError& error) {
  return {std::nullopt, fmt::format("a run for it failed: {}", error.what()), run.elements};
}

QuickEstimate forecast(const Case& run, double seconds, const std::function<bool()>& stop) {
  QuickEstimate found = quick_estimate(run, std::nullopt, seconds, stop);
  if (found.estimate || fewest_in_a_bar(run) < 4 * fewest || (stop && stop())) return found;
  Case coarser = run;
  coarser.elements = (run.elements + 3) / 4;
  if (!sound(coarser)) return found;
  QuickEstimate other = forecast(coarser, seconds, stop);
  return other.estimate ? other : found;
}

QuickEstimate forecast(Case& run, const AccuracyRequest& request, double seconds,
                       const std::function<bool()>& stop) try {
  AccuracyStudy study;
  study.scene = run;
  study.request = request;
  study.threads = 1;  // whose processor time counts
  study.stop = [clock = Stopwatch(), seconds, &stop] { return clock.seconds() > seconds || (stop && stop()); };
  AccuracyResult found = solve(study);
  run = std::move(found.run);
  return {std::move(found.estimate), "", run.elements};
} catch (const StudyStopped&) {
  return {std::nullopt, fmt::format("the search for the settings of [accuracy] takes longer than {:.2g} s", seconds),
          run.elements};
} catch (const std::exception& error) {
  return {std::nullopt, fmt::format("the search for the settings of [accuracy] failed: {}", error.what()),
          run.elements};
}

}  // namespace viscobar::accuracy
