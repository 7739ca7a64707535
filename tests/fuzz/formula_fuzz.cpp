// A formula, the first byte choosing its variables and whether a copy is tried: it is refused with a reason, or a
// function that gives the same value each time, from each copy, and a finite one where it is constant; the search for
// its breaks ends.

// longest: 200
// seeds: formulas of examples/scenes/*.toml build/fuzz/malformed/scenes/*.toml
#include <bit>
#include <cmath>
#include <cstdint>

#include "claim.hpp"
#include "input/formula.hpp"

namespace viscobar {
namespace {

void read(const std::string& text, std::string_view variables, bool try_copy) {
  using fuzz::claim;
  std::optional<Formula> formula;
  try {
    formula.emplace(text, variables);
  } catch (const FormulaError& error) {
    const std::string what = error.what();
    claim(!what.empty(), "a refused formula gets a reason");
    return;
  }
  for (const char variable : {'x', 't'})
    claim(!formula->uses(variable) || variables.find(variable) != variables.npos, "only what is allowed is used");
  if (formula->is_constant()) claim(std::isfinite(formula->constant()), "a constant is finite");
  const SpaceTimeFunction f = formula->of_x_t();
  const SpaceTimeFunction copy = try_copy ? f : nullptr;
  const auto after = [&](std::optional<double> t) { claim(!t || (*t >= 0.0 && *t <= 2.0), "a break is in its time"); };
  if (const NextBreak next = formula->breaks()) after(next(0.0, 2.0));
  if (const NextBreakAt next = formula->breaks_at()) after(next(0.5, 0.0, 2.0));
  for (const double x : {0.0, 0.5, -1.0, 1e300})
    for (const double t : {0.0, 2.0}) {
      const auto first = std::bit_cast<std::uint64_t>(f(x, t));
      claim(first == std::bit_cast<std::uint64_t>(f(x, t)), "a formula gives the same value twice");
      claim(!copy || first == std::bit_cast<std::uint64_t>(copy(x, t)), "a copy gives the same value");
    }
}

}  // namespace
}  // namespace viscobar

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr std::string_view variables[] = {"x", "t", "xt"};
  viscobar::read(std::string(reinterpret_cast<const char*>(data) + 1, size - 1), variables[data[0] % 3],
                 data[0] >= 128);  // to compile a copy takes longer than all else
  return 0;
}
