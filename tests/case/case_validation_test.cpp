#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <limits>

#include "case/run_cost.hpp"
#include "support/falling_bar.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {
namespace {

Case sound_case() {
  Case run;
  run.scene = falling_bar(0.1, 1.0, 0.1);
  run.elements = 8;
  run.epsilon = 1e-3;
  return run;
}

std::vector<std::string> keys_of(const std::vector<Finding>& findings) {
  std::vector<std::string> keys;
  for (const Finding& one : findings) keys.push_back(one.key);
  std::sort(keys.begin(), keys.end());
  return keys;
}

using Keys = std::vector<std::string>;

TEST(Validation, GoesOnPastValuesThatAreWrongToAllThatCanBeSaid) {
  Case run = sound_case();
  run.scene.bar.density = -1.0;
  run.restitution = 2.0;
  run.tolerance.relative = 0.0;
  run.scene.displacement = [](double x) { return x - 0.5; };  // penetrates
  run.scene.velocity = [](double x) { return 1.0 / x; };
  run.output_every = 1e-12;
  run.method = MethodName::finite_difference;
  run.grading = 4.0;
  EXPECT_EQ(keys_of(faults(resolve(run))),
            (Keys{"bar.density", "contact.restitution", "initial.displacement", "initial.velocity", "mesh.grading",
                  "method.relative_tolerance", "output.every"}));
}

TEST(Validation, JudgesNothingByWhatIsWrong) {
  Case run = sound_case();
  run.end = std::numeric_limits<double>::quiet_NaN();
  run.output_every = 1e-300;
  run.step = 1e-300;
  run.method = MethodName::fully_discrete;
  EXPECT_EQ(keys_of(faults(resolve(run))), Keys{"time.end"});
}

TEST(Validation, SaysNothingAboutKeysKnownToBeFaultyNorByThem) {
  Case run = sound_case();
  run.restitution = 2.0;
  run.method = MethodName::cvode;
  run.scene.bar.viscosity = 0.0;
  run.mass = Mass::redistributed;  // cvode cannot take it without viscosity
  EXPECT_EQ(keys_of(faults(resolve(run))), (Keys{"contact.restitution", "method.name"}));
  EXPECT_EQ(keys_of(faults(resolve(run), {"bar.viscosity", "contact.restitution"})), Keys{});
  EXPECT_EQ(keys_of(faults(resolve(run), {"method.name"})), Keys{"contact.restitution"});
}

TEST(Validation, RefusesWhatDoesNotFitIntoTheMemoryOfTheMachine) {
  Case run = sound_case();
  run.elements = 10'000'000;
  run.method = MethodName::exponential;  // dense: 1.28e16 bytes
  const auto findings = faults(resolve(run));
  ASSERT_EQ(keys_of(findings), Keys{"mesh.elements"});
  EXPECT_NE(findings.front().problem.find("GB of memory"), std::string::npos) << findings.front().problem;
}

TEST(Memory, LimitIsThatOfTheProcessWhereOneIsSet) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer needs more address space than any limit";
#endif
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  const double machine = memory_limit();
  rlimit lower = before;
  lower.rlim_cur = 1'000'000'000;  // the limit of further allocations; there are none until it is taken back
  ASSERT_EQ(setrlimit(RLIMIT_AS, &lower), 0);
  const double limited = memory_limit();
  setrlimit(RLIMIT_AS, &before);
  EXPECT_EQ(limited, std::min(machine, 1e9));
}

}  // namespace
}  // namespace viscobar
