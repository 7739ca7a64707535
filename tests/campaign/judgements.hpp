#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

/// Random bars, solutions of them by another method than the judge's own, and these solutions spoiled in known ways.
/// The judge must call the former sound, and tell of each of the latter what was done to it.
namespace viscobar::campaign {

/// Scene number `index` of the campaign `seed`, as a file: a bar thrown at one obstacle or two, some with a load that
/// brings it back, from elastic to overdamped.
std::string judged_scene(std::uint64_t seed, std::size_t index);

enum class Verdict {
  right,    ///< as it must be
  false_,   ///< a sound solution is blamed, or what was spoiled is not told
  refused,  ///< the scene has no such contact, or what was done changes the motion by less than the solution's error
};

struct JudgedSample {
  Verdict verdict = Verdict::right;
  std::string spoiled;  ///< how
  std::string said;     ///< message of the judge
};

/// Solves the scene by scheme (2.8) on two meshes, whose difference is the error of the finer one, samples it, spoils
/// it in one of ten ways where index is odd, and judges it.
JudgedSample run_judgement(std::uint64_t seed, std::size_t index);

}  // namespace viscobar::campaign
