#include "case/peak_remark.hpp"

#include <algorithm>

namespace viscobar {

std::optional<std::string> peak_remark(const Case& run, const BarSystem& system) {
  const Bar& bar = system.bar();
  double mass = 0.0;
  bool obstacle = false;
  for (const Contact& contact : system.contacts()) {
    if (contact.where == Where::span) continue;
    obstacle = true;
    mass = std::max(mass, system.effective_masses()[contact.unknown]);
  }
  if (!obstacle) return std::nullopt;
  if (is_scheme(run.method) && mass > 0.0)
    return "the peak of an impact has no limit: the scheme stops the mass of a node within a step, with a force that "
           "grows as 1 / method.step";
  if (is_penalised(run.method) && mass > 0.0) {
    if (run.restitution && *run.restitution < 1.0)
      return "the peak of an impact has no limit: the dashpot begins with a force that grows as contact.epsilon^(-1/2)";
    if (mass > effective_epsilon(run) * bar.density * bar.modulus)
      return "the peak of an impact has no limit: the spring stops the mass of a node, with a force that grows as "
             "contact.epsilon^(-1/2)";
  }
  if (bar.viscosity > 0.0)
    return "the peak of an impact has no limit: a viscous bar answers with a force that falls as t^(-1/2) from the "
           "touch on, and a finer mesh or a stiffer spring shows more of it";
  return std::nullopt;
}

}  // namespace viscobar
