// A bar falls on an obstacle.
//
//     u_tt - u_xx - 0.1 u_xxt = 0             0 < x < 1, t < 3
//     0 <= u(0,t) + 0.2  _|_  R(t) >= 0       obstacle below the left end, right end free
//     u(x,0) = 0,  u_t(x,0) = -1
//
// Until t = 0.2 the flight is rigid, u = -t: that contact time is exact. The bar leaves after about the time 2 in which
// a wave runs to its other end and back.
//
// Run: build/release/examples/first_bar
#include <cstdio>
#include <viscobar/viscobar.hpp>

int main() {
  viscobar::Case run;
  run.scene.bar.viscosity = 0.1;
  run.scene.left = viscobar::Obstacle{.gap = 0.2};
  run.scene.displacement = [](double) { return 0.0; };
  run.scene.velocity = [](double) { return -1.0; };
  run.elements = 100;
  run.mass = viscobar::Mass::redistributed;  // contact nodes without mass do not bounce by themselves
  run.epsilon = 1e-6;
  run.end = 3.0;
  run.output_every = 0.25;

  const viscobar::Recording bar = viscobar::record(run);
  for (std::size_t k = 0; k < bar.times.size(); ++k)
    std::printf("t = %4.2f   u(0) = %8.5f   u(1) = %8.5f   R = %7.4f\n", bar.times[k], bar.displacement(k).front(),
                bar.displacement(k).back(), bar.reaction_left[k]);
  for (const viscobar::Event& event : bar.events)
    std::printf("%s at t = %.6f with velocity %.4f\n", event.change == viscobar::Change::closing ? "closes" : "opens",
                event.time, event.velocity);
  std::printf("energy %.4f -> %.4f, dissipated %.4f\n", bar.statistics.energy->initial, bar.statistics.energy->final,
              bar.statistics.energy->dissipated);
  return bar.events.size() == 2 ? 0 : 1;
}
