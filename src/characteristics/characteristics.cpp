#include "viscobar/characteristics/characteristics.hpp"

#include "characteristics/run.hpp"

namespace viscobar {

namespace {

using namespace characteristics;

// Of a look ahead: a few tenths of a second.
constexpr std::size_t pieces_awaited = 10'000;
constexpr double work_awaited = 1e6;  // in pieces that are carried through a passage

void require(const Scene& scene, std::span<const double> times, const Characteristics& method) {
  require_times(times);
  if (const auto why = refusal(scene, times.back() - times.front(), method)) throw Unfit("characteristics", *why);
}

}  // namespace

Statistics integrate(const Scene& scene, const Mesh& mesh, const std::optional<Checkpoint>& from,
                     std::span<const double> times, const Characteristics& method, const Observers& observers) {
  refuse_directions("characteristics", observers);
  require(scene, times, method);
  const StartingPoint start = from ? StartingPoint(*from) : StartingPoint(State{});
  return run_in_parts(start, times, observers, [&](const StartingPoint& begin) {
    return Run(scene, mesh, std::get_if<Checkpoint>(&begin), times, method, observers)();
  });
}

std::optional<double> roughens(const Scene& scene, double end) {
  const double times[] = {0.0, end};
  const Characteristics method{.most_pieces = pieces_awaited};
  const Observers nobody;
  require(scene, times, method);
  try {
    Run(scene, Mesh{scene.bar.length, 1}, nullptr, times, method, nobody, work_awaited)();
  } catch (const IntegrationError& error) {
    if (error.failure != Failure::detail) throw;
    return error.statistics.reached_time;
  }
  return std::nullopt;
}

}  // namespace viscobar
