#include "properties/generator.hpp"
#include "properties/tolerance.hpp"

namespace viscobar::properties {
namespace {

Shape sum(const Shape& a, const Shape& b) { return {a.base + b.base, a.amplitude + b.amplitude, a.waves}; }

TEST(Linearity, WithoutObstaclesMotionsAddUp) {
  expect_always([] {
    Asked asked;
    asked.obstacles = false;
    RandomScene first = *scenes(asked);
    // The same bar and load history, other initial data and another load profile of as many waves.
    RandomScene second = first;
    for (Shape* shape : {&second.displacement, &second.velocity}) {
      shape->base = *signed_sixteenths(16, 16);
      shape->amplitude = *signed_sixteenths(16, 16);
    }
    if (second.load) second.load = Shape{*signed_sixteenths(16, 16), *sixteenths(0, 16), first.load->waves};
    RandomScene both = first;
    both.displacement = sum(first.displacement, second.displacement);
    both.velocity = sum(first.velocity, second.velocity);
    if (both.load) both.load = sum(*first.load, *second.load);
    const Case run = first.read().run;
    const Recording a = record(run), b = record(second.read().run), c = record(both.read().run);
    const double bound = displacement_error(run, largest(a.u)) + displacement_error(run, largest(b.u)) +
                         displacement_error(run, largest(c.u)) +
                         4e-16 * (largest(a.u) + largest(b.u));  // of the sum itself
    for (std::size_t j = 0; j < a.u.size(); ++j)
      if (std::abs(a.u[j] + b.u[j] - c.u[j]) > bound)
        RC_FAIL(fmt::format("u[{}]: {} + {} is not {}, but {} off, above {}\n{}", j, a.u[j], b.u[j], c.u[j],
                            a.u[j] + b.u[j] - c.u[j], bound, second.toml()));
  });
}

}  // namespace
}  // namespace viscobar::properties
