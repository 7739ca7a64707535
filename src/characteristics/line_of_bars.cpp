// A scene as bars and junctions.
#include <fmt/format.h>

#include <algorithm>

#include "characteristics/run.hpp"
#include "dynamics/pieces.hpp"

namespace viscobar::characteristics {

std::vector<LineBar> bars_of(const Scene& scene) {
  std::vector<LineBar> bars;
  for (const SceneBar& one : scene_bars(scene))
    bars.push_back({one.member, one.begin, one.bar.length, one.bar.density, one.area(0.0), one.bar.wave_speed()});
  return bars;
}

double window_of(const std::vector<LineBar>& bars) {
  double window = bars.front().transit();
  for (const LineBar& bar : bars) window = std::min(window, bar.transit());
  return window;
}

NextBreak along(const NextBreak& places, double begin) {
  return [places, begin](double after, double until) -> std::optional<double> {
    const auto at = places(begin + after, begin + until);
    return at ? std::optional(*at - begin) : std::nullopt;
  };
}

std::vector<Junction> junctions_of(const Scene& scene, const std::vector<LineBar>& bars, double window, double start,
                                   const std::vector<InitialData>* data, std::vector<std::vector<BodyPlace>>* places) {
  std::vector<Junction> junctions(1, Junction(window, start));
  if (places) places->assign(1, {});
  const std::size_t members = std::max<std::size_t>(1, scene.chain.size());
  std::size_t bar = 0, body = 0;
  // A face or a rigid body at the joint; it is bonded to the body that is there, if any is.
  bool there = false;
  const auto at_body = [&](std::size_t member, bool right) -> std::size_t {
    if (!there) {
      Junction::Data now{0.0, 0.0};
      if (data && bars[std::min(bar, bars.size() - 1)].member == member) {
        const InitialData& own = (*data)[bar];
        const std::size_t last = right ? own.displacement.size() - 1 : 0, of_v = right ? own.velocity.size() - 1 : 0;
        const double place = right ? 1.0 : 0.0;
        now = {own.displacement(last, place), own.velocity(of_v, place)};
      } else if (data) {
        now = {scene.chain[member].displacement(0.0), scene.chain[member].velocity(0.0)};
      }
      body = junctions.back().add_body(now);
      there = true;
    }
    if (places) places->back().push_back({body, member, right});
    return body;
  };
  for (std::size_t m = 0; m < members; ++m) {
    const bool rigid = !scene.chain.empty() && scene.chain[m].rigid();
    at_body(m, false);
    if (m == 0) junctions.back().add_end(body, scene.left, scene.left_input, false);
    if (rigid) {
      junctions.back().add_mass(body, scene.chain[m].mass, data ? scene.chain[m].velocity(0.0) : 0.0,
                                fmt::format("bar.{}.mass", m + 1));
    } else {
      junctions.back().add_face(body, bars[bar].impedance());
      junctions.emplace_back(window, start);
      if (places) places->emplace_back();
      there = false;
      junctions.back().add_face(at_body(m, true), bars[bar].impedance());
      ++bar;
    }
    if (m + 1 == members) {
      junctions.back().add_end(body, scene.right, scene.right_input, true);
    } else if (const Joint& joint = scene.chain[m].joint; joint.kind != JointKind::bonded) {
      const std::size_t before = body;
      there = false;
      at_body(m + 1, false);
      if (places) places->back().pop_back();  // its own turn tells it
      junctions.back().add_joint(before, body, joint, m + 1);
    }
  }
  for (Junction& junction : junctions) junction.finish();
  return junctions;
}

}  // namespace viscobar::characteristics
