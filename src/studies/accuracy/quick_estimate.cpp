#include "studies/accuracy/quick_estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

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
  if (run.elements < fewest && run.method != MethodName::characteristics) {
    result.why_not = fmt::format("it needs {} elements or more, whose mesh can be halved twice", fewest);
    return result;
  }
  Plan plan(run, std::max(seconds, least_seconds), stop);
  plan.next();
  result.estimate = plan.judge(std::move(solution));
  return result;
} catch (const Stopped&) {
  return {std::nullopt, "it was interrupted", run.elements};
} catch (const TooLong&) {
  return {std::nullopt, fmt::format("its runs take longer than {:.2g} s", std::max(seconds, least_seconds)),
          run.elements};
} catch (const IntegrationError& error) {
  return {std::nullopt, fmt::format("a run for it failed: {}", error.what()), run.elements};
}

QuickEstimate forecast(const Case& run, double seconds) {
  QuickEstimate found = quick_estimate(run, std::nullopt, seconds);
  if (found.estimate || run.elements < 4 * fewest) return found;
  Case coarser = run;
  coarser.elements = (run.elements + 3) / 4;
  if (!validate(coarser).empty()) return found;
  QuickEstimate other = forecast(coarser, seconds);
  return other.estimate ? other : found;
}

}  // namespace viscobar::accuracy
