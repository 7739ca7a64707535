#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "run/telling.hpp"

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

}  // namespace
}  // namespace viscobar::testing_stopwatch
