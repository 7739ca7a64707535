#include "viscobar/case/accuracy.hpp"

#include <fmt/format.h>

#include "case/regime.hpp"

namespace viscobar {

std::string_view name(Goal goal) {
  switch (goal) {
    case Goal::displacement: return "displacement";
    case Goal::end_traces: return "end_traces";
    case Goal::contact_times: return "contact_times";
    case Goal::impulse: return "impulse";
    case Goal::peak_reaction: return "peak_reaction";
    case Goal::end_velocity: return "end_velocity";
  }
  return {};
}

std::string_view meaning(Goal goal) {
  switch (goal) {
    case Goal::displacement: return "displacements, the largest error of all nodes and output times";
    case Goal::end_traces: return "displacements of the two ends, the largest error of all output times";
    case Goal::contact_times: return "times of the contact changes at the ends and joints, the worst of them";
    case Goal::impulse: return "impulses of the reactions, the worst end's or joint's";
    case Goal::peak_reaction: return "peak reactions, the worst end's or joint's; only where they have a limit";
    case Goal::end_velocity: return "velocities of the two ends, the largest error of all output times";
  }
  return {};
}

std::optional<Finding> fault(const AccuracyRequest& request, const Setup& setup) {
  const Case& run = setup.run;
  const bool obstacle = end_obstacles(run.scene) > 0 || has_contact_joint(run.scene);
  const bool of_field =
      request.of == Goal::displacement || request.of == Goal::end_traces || request.of == Goal::end_velocity;
  if (!of_field && !obstacle)
    return Finding{"accuracy.of",
                   fmt::format("is \"{}\", and no end has an obstacle{}; use \"displacement\", "
                               "\"end_traces\" or \"end_velocity\"",
                               name(request.of), run.scene.chain.empty() ? "" : ", nor is a joint a contact")};
  if (request.of == Goal::peak_reaction)
    if (const auto why = peak_remark(setup, setup.system()))
      return Finding{"accuracy.of", fmt::format("is \"peak_reaction\": {}; use \"impulse\" or \"displacement\"", *why)};
  return std::nullopt;
}

}  // namespace viscobar
