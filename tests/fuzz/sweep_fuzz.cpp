// Sweep text: it is refused with findings, or a plan whose first and last case can be named.

// longest: 2048
// seeds: examples/sweeps/*.toml build/fuzz/malformed/sweeps/*.toml
#include <algorithm>
#include <cctype>
#include <cstdint>

#include "claim.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {
namespace {

// A number of five digits may ask for a list of so many values: sound, and slow.
bool is_quick(const std::string& text) {
  std::size_t run = 0;
  for (const char c : text) {
    run = std::isxdigit(static_cast<unsigned char>(c)) || c == '_' || c == 'x' || c == 'o' ? run + 1 : 0;
    if (run > 4 && std::isdigit(static_cast<unsigned char>(c))) return false;
  }
  return true;
}

}  // namespace
}  // namespace viscobar

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace viscobar;
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (!is_quick(text)) return 0;
  try {
    const SweepFile sweep = parse_sweep(text, "sweep.toml");
    fuzz::claim(sweep.plan.size() > 0, "a sweep has cases");
    for (const std::size_t index : {std::size_t{0}, sweep.plan.size() - 1})
      fuzz::claim(case_of(sweep, index).settings.size() >= sweep.plan.keys.size(), "a case names every key");
  } catch (const SceneError& error) {
    fuzz::claim_sound(error);
  }
  return 0;
}
