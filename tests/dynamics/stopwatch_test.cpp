#include "run/stopwatch.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <ctime>
#include <thread>

namespace viscobar::testing_stopwatch {
namespace {

TEST(Stopwatch, DoesNotCountWhatRunsOutside) {
  using namespace std::chrono_literals;
  const auto begin = std::chrono::steady_clock::now();
  Stopwatch watch;
  watch.outside([] { std::this_thread::sleep_for(50ms); });
  const double counted = watch.seconds();
  const double passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_GE(counted, 0.0);
  EXPECT_LE(counted, passed - 0.05);
}

// A sleep of 50 ms takes some microseconds of the processor.
TEST(Stopwatch, CountsWhatTheProcessorDoesAndNoWaiting) {
  using namespace std::chrono_literals;
  Stopwatch watch;
  std::this_thread::sleep_for(50ms);
  EXPECT_LT(watch.seconds(), 0.025);
  const std::clock_t begin = std::clock();
  while (std::clock() - begin < CLOCKS_PER_SEC / 50) continue;
  EXPECT_GE(watch.seconds(), 0.02 - 1e-6);
}

}  // namespace
}  // namespace viscobar::testing_stopwatch
