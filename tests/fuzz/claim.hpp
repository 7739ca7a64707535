#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>

#include "viscobar/input/scene_file.hpp"

namespace viscobar::fuzz {

/// Ends the fuzzer with a finding when a claim about its input does not hold.
inline void claim(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "claim broken: %s\n", what.c_str());
  std::abort();
}

/// Every refusal has at least one finding, each at a place, on one line, with words.
inline void claim_sound(const SceneError& error) {
  claim(!error.diagnostics.empty(), "an error has a diagnostic");
  for (const Diagnostic& one : error.diagnostics) {
    claim(one.line >= 1 && one.column >= 1, "lines and columns count from 1");
    claim(!one.message.empty(), "a diagnostic has a message");
    claim(one.text().find('\n') == std::string::npos, "a diagnostic is one line: " + one.text());
  }
}

}  // namespace viscobar::fuzz
