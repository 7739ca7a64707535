// Scene text, and after each of the first 0x1E bytes an override: reading gives a case whose description reads back as
// the same, or a SceneError, and nothing else.

// longest: 2048
// seeds: examples/scenes/*.toml build/fuzz/malformed/scenes/*.toml
#include <algorithm>
#include <cstdint>

#include "claim.hpp"
#include "input/toml_text.hpp"
#include "support/description.hpp"

namespace viscobar {
namespace {

constexpr std::size_t most_overrides = 4;  // more of them cost time and show nothing new

// Checking the initial data of a fine mesh takes seconds and shows nothing that a coarse one does not.
SceneFile parse(const std::string& text, const std::vector<std::string>& overrides) {
  return parse_scene(text, "scene.toml", overrides,
                     [](Case& run) { run.elements = std::min(run.elements, std::size_t{32}); });
}

void read(const std::string& text, const std::vector<std::string>& overrides) {
  try {
    const std::string description = parse(text, overrides).description();
    fuzz::claim(parse("", overrides_of(description)).description() == description,
                "a scene reads back: " + description);
  } catch (const SceneError& error) {
    fuzz::claim_sound(error);
    for (const Diagnostic& one : error.diagnostics)
      fuzz::claim(is_utf8(one.text()), "a diagnostic can be printed as JSON");
  }
}

}  // namespace
}  // namespace viscobar

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string input(reinterpret_cast<const char*>(data), size);
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= size && parts.size() <= viscobar::most_overrides;) {
    const std::size_t end = std::min(input.find('\x1e', begin), size);
    parts.push_back(input.substr(begin, end - begin));
    begin = end + 1;
  }
  viscobar::read(parts.front(), {parts.begin() + 1, parts.end()});
  return 0;
}
