// Random requests with kinks, jumps, patches, pulses and short waves in x and t, judged by the cosine series: how many
// are kept and false. Run: build/release/tests/measure_broken_data [COUNT [SEED]]
#include "support/broken_data.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <exception>

#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"

int main(int count, char** words) {
  using namespace viscobar;
  const int scenes = count > 1 ? std::atoi(words[1]) : 500, seed = count > 2 ? std::atoi(words[2]) : 1;
  int kept = 0, wrong = 0, failed = 0;
  for (int i = 0; i < scenes; ++i) {
    const BrokenData data(static_cast<unsigned>(seed + i));
    try {
      AccuracyStudy study;
      const SceneFile scene = parse_scene(data.text(), "scene");
      study.scene = scene.run;
      study.request = *scene.accuracy;
      const AccuracyResult result = solve(study);
      const double error = data.wrong(record(result.run));
      kept += result.estimate.kept;
      if (!result.estimate.kept || error > data.error)
        fmt::print("seed {}: {}, {} elements, asked {:.1e}, estimate {:.1e}, error {:.1e} {}\n", seed + i,
                   result.estimate.kept ? "KEPT AND FALSE" : "not kept", result.run.elements, data.error,
                   result.estimate.total, error, result.estimate.doubt);
      if (!result.estimate.kept || error > data.error) fmt::print("{}\n", data.text());
      wrong += result.estimate.kept && error > data.error;
    } catch (const std::exception& error) {
      ++failed;
      fmt::print("seed {}: {}\n", seed + i, error.what());
    }
  }
  fmt::print("{} requests, {} kept, {} of them false, {} failed\n", scenes, kept, wrong, failed);
  return wrong + failed > 0 ? 1 : 0;
}
