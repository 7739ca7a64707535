// Bars thrown at stops, against solutions made apart: Laplace transforms of viscous bars, and delay equations of
// elastic ones.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string_view>

#include "laws/scene.hpp"

namespace viscobar::laws {
namespace {

struct Thrown {
  double ends, impulse;  // when the contact ends, and what it gave
};

Thrown thrown(const std::string& stop, double viscosity, int elements, const char* method) {
  const Outcome run = outcome(thrown_bar(stop, viscosity, elements, 2.9, method, 1e-11));
  // The end may come back for a moment; the contact is what lasts.
  const Event& last = run.events.back();
  EXPECT_NEAR(run.statistics.energy->balance_error(), 0.0, 1e-7) << method;
  return {last.time, last.impulse.value_or(0.0)};
}

// A stop k, c on the bar of Laplace's variable s has N = s^-2 / (1 / (k + c s) + 1 / D), D = S tanh(q); the numbers are
// inverse transforms by Talbot's method.
TEST(ThrownBar, OfKelvinAndVoigtComesToItsTransformWithOrderFour) {
  struct Row {
    double stiffness, damping, ends, impulse;
  };
  for (const Row& row : {Row{10, 0, 2.115699138166, 1.750566074645}, Row{10, 0.5, 2.113973732551, 1.732706906619},
                         Row{100, 1, 1.932397716277, 1.662087600799}})
    for (const char* method : linear_methods) {
      SCOPED_TRACE(fmt::format("{} k {} c {}", method, row.stiffness, row.damping));
      const std::string stop = contact("spring_damper", row.stiffness, row.damping);
      const int n = std::string_view(method) == "exponential" ? 40 : 100;  // its matrices are dense
      const Thrown coarse = thrown(stop, 0.1, n / 2, method), fine = thrown(stop, 0.1, n, method);
      // Prototypes made apart, on 80 elements, are off by 1.9e-8 at most, impulses by 4e-9.
      const double bound = std::pow(100.0 / n, 4);
      EXPECT_NEAR(fine.ends, row.ends, 1e-8 * bound);
      EXPECT_NEAR(fine.impulse, row.impulse, 2.5e-9 * bound);
      EXPECT_GT(std::log2(std::abs(coarse.ends - row.ends) / std::abs(fine.ends - row.ends)), 3.3);
      EXPECT_GT(std::log2(std::abs(coarse.impulse - row.impulse) / std::abs(fine.impulse - row.impulse)), 3.6);
    }
}

// d' = 2 p - N with p = 1/2 on (0, 2), then p(t) = p(t - 2) - N(t - 2), at the end of an elastic bar. The kink of the
// touch travels in the mesh, so the order is less than that of smooth motion.
TEST(ThrownBar, ThatIsElasticComesToItsDelayEquation) {
  struct Row {
    std::string stop;
    double ends, impulse;
  };
  for (const Row& row : {Row{contact("spring_damper", 3), 2.559202701351, 1.982917100808},
                         Row{contact("hertz", 10), 2.3991512853, 1.9951111201},
                         Row{contact("hunt_crossley", 10, 1), 2.4336742209, 1.9292329287}}) {
    SCOPED_TRACE(row.stop);
    const Thrown coarse = thrown(row.stop, 0.0, 50, "cvode"), fine = thrown(row.stop, 0.0, 200, "cvode");
    // Measured: 2.8e-6, 6.4e-7, 5.3e-7 of the times and 4e-8, 6e-9, 4e-9 of the impulses on 200 elements.
    EXPECT_NEAR(fine.ends, row.ends, 5e-6);
    EXPECT_NEAR(fine.impulse, row.impulse, 1e-7);
    EXPECT_LT(std::abs(fine.ends - row.ends), 0.25 * std::abs(coarse.ends - row.ends));
    EXPECT_LT(std::abs(fine.impulse - row.impulse), 0.1 * std::abs(coarse.impulse - row.impulse));
  }
}

}  // namespace
}  // namespace viscobar::laws
