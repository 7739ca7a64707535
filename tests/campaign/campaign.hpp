#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "viscobar/input/scene_file.hpp"

/// Random scenes in which bars fly, bounce, chatter and come to rest under load, run by an adaptive method and judged
/// by matrix exponentials: does the method keep its promise, max |u - u_exact| <= 100 (relative max|u| + absolute)?
namespace viscobar::campaign {

/// Scene number `index` of the campaign `seed`, as a file. The same on every machine.
///
/// Penalties from 1e-14 to 1 and restitutions from 0 to 1 on every mass, viscosities from 0 to strongly overdamped,
/// units within a decade of one, steady loads and smooth ones of time, obstacles at the ends and along the span, all
/// adaptive methods at tolerances from 1e-4 to 1e-9.
std::string scene_text(std::uint64_t seed, std::size_t index);

enum class Outcome {
  kept,       ///< within the promise
  magnified,  ///< beyond it, by no more than the scene magnifies a change of its initial data
  wrong,      ///< beyond that, and nothing was said
  alarmed,    ///< beyond that, and said
  stopped,    ///< ended with an error that says why
  too_long,   ///< more than `longest` steps, of the method or of the judge: not judged
};

inline constexpr std::size_t longest = 100'000;

struct Judged {
  Outcome outcome = Outcome::kept;
  double error = 0.0;          ///< max |u - u_exact|, in promises
  double magnification = 1.0;  ///< measured where the error is beyond the promise
  std::size_t events = 0;      ///< contact changes
  double balance = 0.0;        ///< |balance error| over 100 relative tolerances of the largest term
  double late = 0.0;           ///< LateOpening::ratio
  std::string said;            ///< the alarm, or the error
  std::string phantom;         ///< a contact change that cannot be
};

Judged judge(const SceneFile& scene);

}  // namespace viscobar::campaign
