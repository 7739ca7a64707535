#include <gtest/gtest.h>

#include "record/run_outcome.hpp"

namespace viscobar {
namespace {

// Ten steps at a time, a thousand are many.
std::size_t warnings_of(double step, std::size_t steps) {
  PaceWatch watch(0.0, 1.0, 10);
  std::size_t warnings = 0;
  for (std::size_t n = 1; n <= steps; ++n) warnings += watch.heard(static_cast<double>(n) * step).has_value();
  return warnings;
}

TEST(PaceWatch, SpeaksOnceOfARunWhoseStepsAreTooShortForItsTime) {
  EXPECT_EQ(warnings_of(1e-6, 9), 0u) << "not before it has looked";
  EXPECT_EQ(warnings_of(1e-6, 10), 1u);
  EXPECT_EQ(warnings_of(1e-6, 1000), 1u);
  EXPECT_EQ(warnings_of(0.0, 10), 1u) << "no time has passed at all";
}

TEST(PaceWatch, IsSilentWhereTheEndIsNear) {
  EXPECT_EQ(warnings_of(2e-3, 500), 0u);
  EXPECT_EQ(warnings_of(1.0, 10), 0u);
}

TEST(PaceWatch, LooksAfterSomeSecondsOnAnyMesh) {
  EXPECT_EQ(PaceWatch::some_seconds(2), 1'000'000u);
  EXPECT_EQ(PaceWatch::some_seconds(1000), 100'000u);
  EXPECT_EQ(PaceWatch::some_seconds(1'000'000), 1000u);
}

TEST(PaceWatch, SaysWhatToChange) {
  PaceWatch watch(0.0, 1.0, 10);
  std::optional<std::string> said;
  for (int n = 1; n <= 10; ++n) said = watch.heard(1e-5 * n);
  ASSERT_TRUE(said);
  EXPECT_NE(said->find("from t = 0 to 0.0001, at that pace the end is 1.0e+05 steps away"), std::string::npos) << *said;
  EXPECT_NE(said->find("time.end"), std::string::npos);
}

}  // namespace
}  // namespace viscobar
