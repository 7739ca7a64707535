#include "properties/generator.hpp"
#include "properties/tolerance.hpp"

namespace viscobar::properties {
namespace {

// The dashpot that gives a penalised contact its restitution pulls at the end of a contact, as docs/model.md says: so
// without one.
TEST(Contact, PushesAndOnlyWhereItTouches) {
  expect_always([] {
    Asked asked;
    asked.restitution = false;
    const RandomScene scene = *scenes(asked);
    const Case run = scene.read().run;
    const Recording recording = record(run);
    RC_CLASSIFY(!recording.events.empty(), "contact");
    const double d = displacement_error(run, largest(recording.u));
    // The reaction of a scheme at t_n holds the node at t_{n+1}, so that it may be a step's way off; twice that,
    // because the velocity is known at the output times only.
    const double away = d + (is_scheme(run.method) ? 2.0 * *run.step * largest(recording.v) : 0.0);
    // A reaction is as wrong as the displacement is by the spring, or where there is none by the stress of the end
    // element: at most that of an end node moved by d, with its velocity.
    const Bar& bar = run.scene.bar;
    const double h = run.mesh().spacing();
    const double bound = d * (is_penalised(run.method) ? 1.0 / *run.epsilon
                                                       : (bar.modulus + bar.viscosity * fastest_frequency(run)) / h +
                                                             bar.density * h * std::pow(fastest_frequency(run), 2));
    for (std::size_t k = 0; k < recording.times.size(); ++k) {
      const auto u = recording.displacement(k);
      const auto check = [&](const char* side, const End& end, double place, double reaction) {
        if (end.kind == "fixed") return;  // a fixed end pulls, too
        if (end.kind == "free" && reaction == 0.0) return;
        if (reaction < -bound)
          RC_FAIL(fmt::format("the {} obstacle pulls by {} at t = {}", side, reaction, recording.times[k]));
        if (reaction > bound && place + end.gap > away)
          RC_FAIL(fmt::format("the {} obstacle pushes by {} at t = {} from {} away", side, reaction, recording.times[k],
                              place + end.gap));
      };
      if (scene.span_gap) continue;  // the reaction of the span at the end node is not the end's
      check("left", scene.left, u.front(), recording.reaction_left[k]);
      check("right", scene.right, u.back(), recording.reaction_right[k]);
    }
  });
}

}  // namespace
}  // namespace viscobar::properties
