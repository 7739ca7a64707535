// Errors of random throws as they are estimated, beside the true ones (see campaign/estimates.hpp): prints each scene
// whose estimate is below a half of the error, and how the ratios are spread. Run:
//     cmake --build --preset release --target measure_estimates && build/release/tests/measure_estimates [COUNT [SEED]]
// `measure_estimates COUNT SEED chatter` takes bars that chatter, `bounces` those that bounce, with masses on their
// ends. `measure_estimates INDEX SEED throws show`, or another kind for throws, prints a scene as a file.
#include "campaign/estimates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "studies/accuracy/quick_estimate.hpp"
#include "viscobar/input/scene_file.hpp"

namespace {

using namespace viscobar;

void tell(const std::string& what, std::vector<double> ratios) {
  std::ranges::sort(ratios);
  const auto quantile = [&](double share) {
    return ratios[static_cast<std::size_t>(share * static_cast<double>(ratios.size() - 1))];
  };
  const auto low = std::ranges::count_if(ratios, [](double ratio) { return ratio < 1.0 / 3.0; });
  fmt::print("| {} | {} | {} | {:.2g} | {:.2g} | {:.2g} | {:.2g} |\n", what, ratios.size(), low, ratios.front(),
             quantile(0.01), quantile(0.5), quantile(0.9));
}

}  // namespace

int main(int count, char** words) {
  const auto argument = [&](int i, std::size_t otherwise) {
    return count > i ? static_cast<std::size_t>(std::strtoull(words[i], nullptr, 10)) : otherwise;
  };
  const std::size_t scenes = argument(1, 1000), seed = argument(2, 1);
  const std::string kind = count > 3 ? words[3] : "";
  const auto scene = kind == "chatter"   ? &campaign::chattering_scene
                     : kind == "bounces" ? &campaign::bouncing_scene
                                         : &campaign::thrown_scene;
  if (count > 4) {
    fmt::print("{}", scene(seed, scenes));
    return 0;
  }
  std::map<std::string, std::vector<double>> ratios;
  std::size_t blunt = 0, none = 0, exact = 0;
  for (std::size_t i = 0; i < scenes; ++i) {
    const Case run = parse_scene(scene(seed, i), "scene").run;
    if (run.method == MethodName::characteristics && ++exact) continue;
    const auto truth = campaign::true_error(run);
    const auto told = accuracy::quick_estimate(run, std::nullopt, 10.0);
    if (!told.estimate && ++none) continue;
    if ((!truth || !truth->sharp()) && ++blunt) continue;
    const double ratio = told.estimate->total / truth->error;
    ratios["all"].push_back(ratio);
    ratios[fmt::format("`{}`{}", name(run.method), run.scene.span ? ", along the bar" : "")].push_back(ratio);
    ratios[run.restitution ? fmt::format("restitution {}", *run.restitution) : "no restitution"].push_back(ratio);
    if (ratio < 0.5) {
      fmt::print("{}: {} on {} elements, error {:.2e}, estimate {:.2e} (space {:.1e}, penalty {:.1e}, time {:.1e})\n",
                 i, name(run.method), run.elements, truth->error, told.estimate->total, told.estimate->space,
                 told.estimate->penalty, told.estimate->time);
      std::fflush(stdout);
    }
  }
  fmt::print(
      "| scenes | number | below 1/3 | estimate / error: least | 1 % | median | 90 % |\n|---|---|---|---|---|---|---|\n");
  for (const auto& [what, all] : ratios) tell(what, all);
  fmt::print("{} exact, {} without an estimate, {} whose truth is not ten times sharper\n", exact, none, blunt);
}
