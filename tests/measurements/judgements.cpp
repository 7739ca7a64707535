// Judges sound solutions of random bars, and spoiled ones (see campaign/judgements.hpp): prints each false verdict, and
// the counts of each way to spoil. Run:
//     cmake --build --preset release --target measure_judgements && build/release/tests/measure_judgements [SEED]
//     [COUNT]
// `measure_judgements SEED INDEX show` prints the scene as a file, and what was told.
#include "campaign/judgements.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <map>
#include <mutex>
#include <string_view>

#include "studies/parallel.hpp"

int main(int argc, char** argv) {
  using namespace viscobar;
  using namespace viscobar::campaign;
  const auto argument = [&](int i, std::size_t otherwise) {
    return argc > i ? static_cast<std::size_t>(std::strtoull(argv[i], nullptr, 10)) : otherwise;
  };
  const std::size_t seed = argument(1, 1), count = argument(2, 300);
  if (argc > 3 && std::string_view(argv[3]) == "show") {
    const JudgedSample one = run_judgement(seed, count);
    fmt::print("{}# {}: {}\n", judged_scene(seed, count), one.spoiled, one.said);
    return 0;
  }
  std::map<std::string, std::array<std::size_t, 3>> counts;
  std::mutex mutex;
  std::size_t wrong = 0;
  parallel_for(count, [&](std::size_t index) {
    const JudgedSample one = run_judgement(seed, index);
    const std::lock_guard lock(mutex);
    ++counts[one.spoiled][static_cast<std::size_t>(one.verdict)];
    if (one.verdict != Verdict::false_) return;
    ++wrong;
    fmt::print("{:6} {}: {}\n", index, one.spoiled, one.said);
  });
  fmt::print("{:20} {:>6} {:>6} {:>6}\n", "spoiled by", "right", "false", "refused");
  for (const auto& [way, of] : counts) fmt::print("{:20} {:6} {:6} {:6}\n", way, of[0], of[1], of[2]);
  return wrong == 0 ? 0 : 1;
}
