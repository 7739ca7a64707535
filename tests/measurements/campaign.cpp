// Runs random scenes and judges them (see campaign/campaign.hpp): prints each that was not within its promise, and the
// counts. Run:
//     cmake --build --preset release --target measure_campaign && build/release/tests/measure_campaign [SEED] [COUNT]
//     [FIRST]
// `measure_campaign SEED 1 INDEX show` prints the scene as a file.
#include "campaign/campaign.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <mutex>
#include <string_view>

#include "studies/parallel.hpp"

int main(int argc, char** argv) {
  using namespace viscobar;
  using namespace viscobar::campaign;
  const auto argument = [&](int i, std::size_t otherwise) {
    return argc > i ? static_cast<std::size_t>(std::strtoull(argv[i], nullptr, 10)) : otherwise;
  };
  const std::size_t seed = argument(1, 1), count = argument(2, 10'000), first = argument(3, 0);
  if (argc > 4 && std::string_view(argv[4]) == "show") {
    fmt::print("{}", scene_text(seed, first));
    return 0;
  }
  constexpr std::array names = {"kept", "magnified", "wrong", "alarmed", "stopped", "too long"};
  std::array<std::size_t, names.size()> counts{};
  std::mutex mutex;
  parallel_for(count, [&](std::size_t k) {
    const std::size_t index = first + k;
    const SceneFile scene = parse_scene(scene_text(seed, index), "random.toml");
    const Judged judged = judge(scene);
    const std::lock_guard lock(mutex);
    ++counts[static_cast<std::size_t>(judged.outcome)];
    if (judged.outcome == Outcome::kept && judged.said.empty() && judged.balance < 1.0 && judged.late < 0.3) return;
    fmt::print(
        "{:6} {:9} {:6} error {:.2g} magnification {:.2g} balance {:.2g} late {:.2g} events {} epsilon {:.2g} e {} "
        "rtol {:.1g} {}\n",
        index, names[static_cast<std::size_t>(judged.outcome)], name(scene.run.method), judged.error,
        judged.magnification, judged.balance, judged.late, judged.events, *scene.run.epsilon,
        scene.run.restitution ? fmt::format("{:.2g}", *scene.run.restitution) : "-", scene.run.tolerance.relative,
        judged.said);
  });
  for (std::size_t k = 0; k < names.size(); ++k) fmt::print("{} {}\n", names[k], counts[k]);
  return counts[static_cast<std::size_t>(Outcome::wrong)] == 0 ? 0 : 1;
}
