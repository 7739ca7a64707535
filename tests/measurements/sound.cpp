// Runs sound random scenes by every method, and falsifies accounts of others (see campaign/sound.hpp): prints each run
// that fails though it is sound, or does not though it is falsified, and the counts. Run:
//     cmake --build --preset release --target measure_sound && build/release/tests/measure_sound [SEED] [COUNT]
//     [SPOILED]
// `measure_sound SEED INDEX show` prints the scene as a file.
#include "campaign/sound.hpp"

#include <fmt/format.h>

#include <array>
#include <atomic>
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
  const std::size_t seed = argument(1, 1), count = argument(2, 5'000), spoiled = argument(3, 500);
  if (argc > 3 && std::string_view(argv[3]) == "show") {
    fmt::print("{}", sound_scene(seed, count));
    return 0;
  }
  constexpr std::array names = {"quiet", "warned", "failed", "refused", "too long"};
  std::array<std::size_t, names.size()> of_sound{}, of_spoiled{};
  std::mutex mutex;
  parallel_for(count, [&](std::size_t index) {
    const Sounded sounded = run_sound(sound_scene(seed, index));
    const std::lock_guard lock(mutex);
    ++of_sound[static_cast<std::size_t>(sounded.end)];
    if (sounded.end == End::warned || sounded.end == End::failed)
      fmt::print("{:6} {:8} {}\n", index, names[static_cast<std::size_t>(sounded.end)], sounded.said);
  });
  // Falsified accounts: so many, of scenes behind the sound ones.
  std::atomic<std::size_t> made{0};
  for (std::size_t first = count; made < spoiled && first < count + 20 * spoiled; first += 100)
    parallel_for(100, [&](std::size_t k) {
      if (made >= spoiled) return;
      const Sounded sounded = run_spoiled(sound_scene(seed, first + k), seed, first + k);
      const std::lock_guard lock(mutex);
      ++of_spoiled[static_cast<std::size_t>(sounded.end)];
      if (sounded.end == End::refused) return;
      ++made;
      if (sounded.end != End::failed)
        fmt::print("{:6} falsified, and {}: {}\n", first + k, names[static_cast<std::size_t>(sounded.end)],
                   sounded.said);
    });
  for (std::size_t k = 0; k < names.size(); ++k)
    fmt::print("{:8} {:6} sound {:6} falsified\n", names[k], of_sound[k], of_spoiled[k]);
  const auto at = [](End end) { return static_cast<std::size_t>(end); };
  return of_sound[at(End::failed)] == 0 && of_spoiled[at(End::quiet)] + of_spoiled[at(End::warned)] == 0 ? 0 : 1;
}
