#include <bit>

#include "properties/generator.hpp"
#include "properties/tolerance.hpp"

namespace viscobar::properties {
namespace {

void expect_close(const Recording& first, std::size_t k, std::size_t i, double a, double b, double bound) {
  if (std::abs(a - b) > bound)
    RC_FAIL(fmt::format("u of node {} at t = {}: {} and {}, {} apart, above {}", i, first.times[k], a, b,
                        std::abs(a - b), bound));
}

TEST(Symmetry, ABarTurnedRoundMovesAlike) {
  expect_always([] {
    const RandomScene scene = *scenes();
    RandomScene turned = scene;
    std::swap(turned.left, turned.right);
    turned.mirrored = true;
    const Case run = scene.read().run;
    const Recording one = record(run), other = record(turned.read().run);
    const double bound = 2.0 * displacement_error(run, largest(one.u));
    const std::size_t last = one.mesh.nodes() - 1;
    RC_CLASSIFY(!one.events.empty(), "contact");
    for (std::size_t k = 0; k < one.times.size(); ++k)
      for (std::size_t i = 0; i <= last; ++i)
        expect_close(one, k, i, one.displacement(k)[i], other.displacement(k)[last - i], bound);
  });
}

// The equations know no time but that of the load.
TEST(Symmetry, ALateStartUnderADelayedLoadIsTheSameMotionLater) {
  expect_always([] {
    RandomScene scene = *scenes();
    const double delay = *power_of_two(0, 4);
    const Case run = scene.read().run;
    scene.delay = delay;
    const Case later = scene.read().run;
    const BarSystem system = resolve(later).system();
    std::vector<double> times = run.output_times(), u;
    for (double& t : times) t += delay;
    Observers observers;
    observers.snapshot = [&](const Snapshot& now) { u.insert(u.end(), now.u.begin(), now.u.end()); };
    simulate(resolve(later), system, times, observers);
    const Recording reference = record(run);
    RC_CLASSIFY(!reference.events.empty(), "contact");
    const double bound = 2.0 * displacement_error(run, largest(reference.u));
    const std::size_t nodes = reference.mesh.nodes();
    RC_ASSERT(u.size() == reference.u.size());
    for (std::size_t k = 0; k < times.size(); ++k)
      for (std::size_t i = 0; i < nodes; ++i)
        expect_close(reference, k, i, reference.displacement(k)[i], u[k * nodes + i], bound);
  });
}

// Units of length, time, displacement and stress, all powers of two: every product, quotient and square root is the
// same number with another exponent. So the digits are the same, but for odeint: it reads its Jacobian off differences
// between displacements of the bar's length and none, and here displacements have a unit of their own.
TEST(Symmetry, OtherUnitsGiveTheSameDigits) {
  expect_always([] {
    Asked asked;
    asked.in_motion = true;
    RandomScene scene = *scenes(asked);
    // The absolute tolerance, one number for displacement and velocity, has no unit: it is lost in the rounding of the
    // relative one, for a bar that moves from the beginning.
    scene.absolute = 1e-30;
    // The reaction is a stress at an end, a force per volume under a span: with both, the length has to stay.
    const double length = scene.span_gap ? 1.0 : *scale();
    const double time = *scale(), displacement = *scale(), stress = *scale();
    RandomScene other = scene;
    const double modulus = stress * length / displacement;
    other.length *= length;
    other.modulus *= modulus;
    other.viscosity *= modulus * time;
    other.density *= modulus * time * time / (length * length);
    for (End* end : {&other.left, &other.right}) end->gap *= displacement;
    if (other.span_gap) *other.span_gap *= displacement;
    for (double* value : {&other.displacement.base, &other.displacement.amplitude}) *value *= displacement;
    for (double* value : {&other.velocity.base, &other.velocity.amplitude}) *value *= displacement / time;
    if (other.load)
      for (double* value : {&other.load->base, &other.load->amplitude}) *value *= stress / length;
    other.frequency /= time;
    other.end *= time;
    other.epsilon *= displacement / stress;
    other.absolute *= displacement;
    const Case run = scene.read().run;
    const Recording one = record(run), two = record(other.read().run);
    RC_CLASSIFY(!one.events.empty(), "contact");
    const double bound = run.method != MethodName::odeint ? 0.0 : 2.0 * displacement_error(run, largest(one.u));
    for (std::size_t j = 0; j < one.u.size(); ++j)
      if (std::abs(one.u[j] - two.u[j] / displacement) > bound)
        RC_FAIL(fmt::format("u[{}] = {} and {}, in units of {}, steps {} and {}\n{}", j, one.u[j],
                            two.u[j] / displacement, displacement, one.statistics.steps, two.statistics.steps,
                            other.toml()));
    RC_ASSERT(bound > 0.0 || one.events.size() == two.events.size());
  });
}

}  // namespace
}  // namespace viscobar::properties
