// Does the penalised bar tend to the paper's fully discrete scheme? A study by the library, without a scene file.
//
//     u_tt - u_xx - 0.01 u_xxt = 0            0 < x < 1, t < 6
//     obstacles at both ends, gap 0.1         R = penetration / epsilon, or scheme (2.8)
//     u(x,0) = x (1 - x),  u_t(x,0) = -x (1 - x)
//
// On the consistent mass the contact nodes bounce on their penalty and the difference stays at some 3e-3 however small
// epsilon is; on the redistributed mass, whose contact nodes have none, it vanishes (docs/penalty-limit.md).
//
// Run: build/release/examples/limit
#include <cstdio>
#include <viscobar/viscobar.hpp>

int main() {
  using namespace viscobar;
  LimitStudy study;
  study.scene.scene.bar.viscosity = 0.01;
  study.scene.scene.left = study.scene.scene.right = Obstacle{0.1};
  study.scene.scene.displacement = [](double x) { return x * (1 - x); };
  study.scene.scene.velocity = [](double x) { return -x * (1 - x); };
  study.scene.elements = 27;
  study.scene.end = 6.0;
  study.scene.output_every = 0.01;
  study.scene.step = 1e-4;  // of scheme (2.8)
  study.epsilons = decades(1e-2, 1e-6);

  bool as_expected = true;
  for (const Mass mass : {Mass::consistent, Mass::redistributed}) {
    study.scene.mass = mass;
    const LimitResult result = limit_of(study);
    std::printf("mass %s\n  epsilon   contact changes   penetration   difference to the scheme\n", name(mass).data());
    for (const LimitRow& row : result.rows)
      std::printf("  %7.0e   %15zu   %11.2e   %24.2e\n", row.epsilon, row.events, row.max_penetration,
                  row.difference_to_scheme);
    const LimitOrders& orders = result.orders.front();
    std::printf("  the scheme's own error in dt: %.1e; verdict: %s\n\n", orders.scheme_error,
                name(orders.verdict).data());
    as_expected &= orders.verdict == (mass == Mass::consistent ? Verdict::plateau : Verdict::converges);
  }
  return as_expected ? 0 : 1;
}
