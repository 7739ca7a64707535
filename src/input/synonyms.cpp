#include "input/synonyms.hpp"

#include <algorithm>
#include <iterator>

namespace viscobar {

namespace {

struct Synonym {
  std::string_view word, ours;
};

constexpr Synonym synonyms[] = {
    {"alpha", "viscosity"},
    {"eta", "viscosity"},
    {"damping", "viscosity"},
    {"rho", "density"},
    {"young", "modulus"},
    {"youngs", "modulus"},
    {"youngs_modulus", "modulus"},
    {"elasticity", "modulus"},
    {"elastic_modulus", "modulus"},
    {"e", "modulus"},
    {"type", "kind"},
    {"l", "length"},
    {"u", "displacement"},
    {"u0", "displacement"},
    {"v", "velocity"},
    {"v0", "velocity"},
    {"position", "gap"},
    {"distance", "gap"},
    {"force", "density"},
    {"t", "end"},
    {"t_end", "end"},
    {"duration", "end"},
    {"j", "elements"},
    {"nodes", "elements"},
    {"cells", "elements"},
    {"penalty", "epsilon"},
    {"compliance", "epsilon"},
    {"dt", "step"},
    {"h", "step"},
    {"rtol", "relative_tolerance"},
    {"atol", "absolute_tolerance"},
    {"tolerance", "relative_tolerance"},
    {"interval", "every"},
    {"dt_out", "every"},
    {"wall", "obstacle"},
    {"contact", "obstacle"},
    {"signorini", "obstacle"},
    {"rigid", "obstacle"},
    {"clamped", "fixed"},
    {"dirichlet", "fixed"},
    {"none", "free"},
    {"neumann", "free"},
    {"diagonal", "lumped"},
    {"fd", "finite_difference"},
    {"rk45", "odeint"},
    {"solver", "method"},
    {"integrator", "method"},
    {"material", "bar"},
    {"forcing", "load"},
};

}  // namespace

std::string_view usual_name(std::string_view word) {
  const std::string plain = plain_name(word);
  const auto found =
      std::find_if(std::begin(synonyms), std::end(synonyms), [&](const Synonym& one) { return one.word == plain; });
  return found == std::end(synonyms) ? word : found->ours;
}

}  // namespace viscobar
