// DRAFT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"

namespace {
using namespace viscobar;
struct Cost { double seconds = 0, work = 0, runs = 0; int notkept = 0; double elements = 0; };
AccuracyResult solved(const SceneFile& scene, std::optional<AccuracyStart> start, Cost& cost) {
  AccuracyStudy study;
  study.scene = scene.run;
  study.request = *scene.accuracy;
  study.threads = 1;
  study.start = start;
  AccuracyResult r;
  double best = 1e300;
  for (int k = 0; k < 3; ++k) {
    const std::clock_t began = std::clock();
    r = solve(study);
    best = std::min(best, static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC);
  }
  cost.seconds += best;
  cost.runs += 1.0 + (double)r.estimate.runs.size();
  cost.work += (double)r.run.elements;
  for (auto& one : r.estimate.runs) cost.work += (double)one.elements;
  cost.notkept += !r.estimate.kept;
  cost.elements += (double)r.run.elements;
  if (std::getenv("VERBOSE")) {
    fmt::print("   {} {:.1e} {} kept {} est/req {:.2f} {:.2f}ms:", r.run.elements, r.run.tolerance.relative, r.run.epsilon.value_or(0), r.estimate.kept, r.estimate.total / *r.estimate.requested, best * 1e3);
    for (auto& one : r.estimate.runs) fmt::print(" {}/{:.0e}{}", one.elements, one.setting.value_or(0), one.search ? "s" : "");
    fmt::print("\n");
  }
  return r;
}
}
int main(int count, char** words) {
  const std::string extra = count > 1 ? words[1] : "";
  const std::string base = "[bar]\nlength=1\nviscosity=0.1\n[left]\nkind=\"obstacle\"\ngap=0.1\n[initial]\nvelocity=-1\n[time]\nend=2.5\n" ;
  fmt::print("request | cold: s work runs notkept sumJ | star8 | chain8 | tree8\n");
  for (const char* error : {"1e-3", "1e-4", "1e-5", "1e-6", "1e-7", "1e-8"}) {
    std::vector<SceneFile> cases;
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 8; ++j) {
        std::vector<std::string> set{fmt::format("bar.viscosity={}", std::pow(10.0, -2.0 + i * 2.0 / 7)), fmt::format("left.gap={}", 0.02 + 0.04 * j), fmt::format("accuracy.error={}", error)};
        if (!extra.empty()) set.push_back(extra);
        cases.push_back(parse_scene(base, "s", set));
      }
    if (std::getenv("SWAP")) { std::vector<SceneFile> o; for (int j = 0; j < 8; ++j) for (int i = 0; i < 8; ++i) o.push_back(cases[i * 8 + j]); cases = o; }
    fmt::print("{}", error);
    for (int strategy = 0; strategy < 4; ++strategy) {
      Cost cost;
      std::vector<std::optional<AccuracyStart>> ends(cases.size());
      const auto run = [&](std::size_t i, std::optional<AccuracyStart> s) {
        if (std::getenv("VERBOSE")) fmt::print("{} {} {}", strategy, i, s ? s->elements : 0);
        const auto r = solved(cases[i], s, cost);
        if (r.estimate.kept) ends[i] = start_at(r.run);
      };
      for (std::size_t b = 0; b < cases.size(); b += 8) {
        if (strategy == 0) for (std::size_t k = 0; k < 8; ++k) run(b + k, std::nullopt);
        if (strategy == 1) { run(b + 4, std::nullopt); for (std::size_t k = 0; k < 8; ++k) if (k != 4) run(b + k, ends[b + 4]); }
        if (strategy == 2) for (std::size_t k = 0; k < 8; ++k) run(b + k, k ? ends[b + k - 1] : std::nullopt);
        if (strategy == 3) for (std::size_t k : {0, 4, 2, 6, 1, 3, 5, 7}) run(b + k, k ? ends[b + (k & (k - 1))] : std::nullopt);
      }
      fmt::print(" | {:.3f} {:.0f} {:.0f} {} {:.0f}", cost.seconds, cost.work, cost.runs, cost.notkept, cost.elements);
      std::fflush(stdout);
    }
    fmt::print("\n");
  }
}
