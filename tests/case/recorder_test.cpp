#include "viscobar/case/recorder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace viscobar {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

Case two_elements() {
  Case run;
  run.elements = 2;
  run.end = 1.0;
  run.output_every = 0.1;
  return run;
}

TEST(Recorder, IsExactForCubicsWhateverTheSteps) {
  const auto u = [](double t) { return 1.0 - 2.0 * t + 0.5 * t * t + 3.0 * t * t * t; };
  const auto v = [](double t) { return -2.0 + t + 9.0 * t * t; };
  const Case run = two_elements();
  Recorder recorder(run, "cubic");
  for (const double t : {0.0, 0.03, 0.37, 0.4, 1.1}) {
    const std::vector<double> a(3, u(t)), b(3, v(t));
    recorder.step(t, a, b, t, -t);
  }
  const Recording found = recorder.recording();
  ASSERT_EQ(fault(found, run), std::nullopt);
  for (std::size_t k = 0; k < found.times.size(); ++k) {
    EXPECT_NEAR(found.displacement(k)[1], u(found.times[k]), 20 * eps);
    EXPECT_NEAR(found.velocity(k)[2], v(found.times[k]), 200 * eps);
    EXPECT_NEAR(found.reaction_left[k], found.times[k], 4 * eps);
  }
}

TEST(Recorder, KeepsTheStatesOfStepsThatEndAtOutputTimesAsTheyAre) {
  const Case run = two_elements();
  Recorder recorder(run, "steps");
  double value = 0.1;
  std::vector<double> given;
  for (int n = 0; n <= 10; ++n) {
    const std::vector<double> u(3, value = std::sqrt(value)), v(3, -value);
    given.push_back(value);
    recorder.step(0.1 * n, u, v);  // 0.1 n is not the output time to the last bit
  }
  const Recording found = recorder.recording();
  for (std::size_t k = 0; k < given.size(); ++k) EXPECT_EQ(found.displacement(k)[0], given[k]);
}

TEST(Recorder, TakesTheEndsAlone) {
  const Case run = two_elements();
  Recorder recorder(run, "ends");
  const std::vector<double> ends = {0.5, -0.5}, rest = {0.0, 0.0};
  recorder.step(0.0, ends, rest);
  recorder.step(1.0, ends, rest);
  const Recording found = recorder.recording();
  EXPECT_EQ(found.mesh.elements, 1u);
  EXPECT_EQ(fault(found, run), std::nullopt);
}

TEST(Recorder, FindsReactionsAndContactChangesThatNoRunHas) {
  const Case run = two_elements();
  const auto fault_of = [&](double reaction, double time, double velocity) {
    Recorder recorder(run, "own");
    const std::vector<double> rest(3, 0.0);
    recorder.step(0.0, rest, rest, reaction);
    recorder.step(1.0, rest, rest, reaction);
    recorder.change({time, Where::left, 0, Change::closing, velocity});
    return fault(recorder.recording(), run);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(fault_of(1.0, 0.5, -1.0), std::nullopt);
  EXPECT_TRUE(fault_of(nan, 0.5, -1.0));
  for (const double time : {99.0, -0.1, nan}) EXPECT_TRUE(fault_of(1.0, time, -1.0)) << time;
  EXPECT_TRUE(fault_of(1.0, 0.5, nan));
}

TEST(Recorder, RefusesWhatCannotBeARun) {
  const std::vector<double> good(3, 0.0), four(4, 0.0), two(2, 0.0);
  std::vector<double> nan(3, std::numeric_limits<double>::quiet_NaN());
  Recorder recorder(two_elements(), "mine");
  EXPECT_THROW(recorder.step(0.1, good, good), std::invalid_argument);
  recorder.step(0.0, good, good);
  EXPECT_THROW(recorder.step(0.0, good, good), std::invalid_argument);
  EXPECT_THROW(recorder.step(0.1, four, four), std::invalid_argument);
  EXPECT_THROW(recorder.step(0.1, two, two), std::invalid_argument);
  EXPECT_THROW(recorder.step(0.1, good, nan), std::invalid_argument);
  EXPECT_EQ(recorder.next(), 0.1);
  EXPECT_THROW(recorder.recording(), std::logic_error);
}

}  // namespace
}  // namespace viscobar
