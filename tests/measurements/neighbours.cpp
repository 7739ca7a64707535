// Savings of the cases of a sweep that begin where a neighbour ended: a table of docs/accuracy-on-request.md. Run:
// build/release/tests/measure_neighbours [METHOD ERROR]
#include "sweep/neighbours.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <vector>

#include "input/described_scene.hpp"
#include "support/processor_seconds.hpp"
namespace {

using namespace viscobar;

constexpr const char* scene =
    "[bar]\nlength=1\n[left]\nkind=\"obstacle\"\n[initial]\nvelocity=-1\n[time]\nend=2.5\n[accuracy]\nerror=1\n";

/// Sums over all cases of a sweep.
struct Sum {
  double seconds = 0.0;  // of the processor, the least of five
  std::size_t runs = 0, search = 0, elements = 0, kept = 0;
};

AccuracyResult solved(const SceneFile& file, const std::optional<AccuracyStart>& start) {
  AccuracyStudy study;
  study.scene = file.run;
  study.request = *file.accuracy;
  study.threads = 1;
  study.start = start;
  return solve(study);
}

void add(Sum& sum, const AccuracyResult& result, double seconds) {
  sum.seconds += seconds;
  sum.runs += 1 + result.estimate.runs.size();
  for (const ErrorEstimate::Run& run : result.estimate.runs) sum.search += run.search ? 1 : 0;
  sum.elements += result.run.elements;
  sum.kept += result.estimate.kept ? 1 : 0;
}

void compare(const char* method, double error) {
  SweepFile sweep;
  sweep.scene_text = scene;
  sweep.settings = {fmt::format("method.name=\"{}\"", method), fmt::format("accuracy.error={}", error)};
  std::vector<double> viscosities, gaps;
  for (int k = 0; k < 8; ++k) viscosities.push_back(std::pow(10.0, -2.0 + k * 2.0 / 7.0));
  for (int k = 0; k < 16; ++k) gaps.push_back(0.02 + 0.02 * k);
  sweep.plan.keys = {{"bar.viscosity", viscosities}, {"left.gap", gaps}};
  heed_scene(sweep);
  const std::vector<std::optional<std::size_t>> of = neighbours(sweep.plan);
  Sum by_themselves, from_neighbours;
  for (std::size_t i = 0; i < of.size(); ++i) {
    const auto file = [&](std::size_t k) { return parse_scene_with(scene, "scene", case_of(sweep, k).settings); };
    std::optional<AccuracyStart> start;
    if (of[i])
      if (const AccuracyResult neighbour = solved(file(*of[i]), {}); neighbour.estimate.kept)
        start = start_at(neighbour.run);
    // In turns, so that a machine that others use slows both alike.
    AccuracyResult alone, begun;
    double least_alone = 1e300, least_begun = 1e300;
    for (int k = 0; k < 5; ++k) {
      least_alone = std::min(least_alone, seconds_of([&] { alone = solved(file(i), {}); }));
      least_begun = std::min(least_begun, seconds_of([&] { begun = solved(file(i), start); }));
    }
    add(by_themselves, alone, least_alone);
    add(from_neighbours, begun, least_begun);
  }
  fmt::print("| {} | {:.0e} | {}, {} | {}, {} | {}, {} | {}, {} | {:.2f}, {:.2f} | {:.2f} |\n", method, error,
             by_themselves.kept, from_neighbours.kept, by_themselves.elements, from_neighbours.elements,
             by_themselves.runs, from_neighbours.runs, by_themselves.search, from_neighbours.search,
             by_themselves.seconds, from_neighbours.seconds, from_neighbours.seconds / by_themselves.seconds);
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** words) {
  fmt::print(
      "| method | request | kept of 128 | elements of the solutions | runs | of the search alone | processor, s | ratio "
      "|\n|---|---|---|---|---|---|---|---|\n");
  if (count > 2) return compare(words[1], std::atof(words[2])), 0;
  for (const double error : {1e-4, 1e-6, 1e-8}) compare("rigid", error);
  for (const double error : {1e-3, 1e-4, 1e-5}) compare("cvode", error);
  for (const double error : {1e-3, 1e-4, 1e-5}) compare("arkode", error);
  for (const double error : {1e-3, 1e-4}) compare("fully_discrete", error);
}
