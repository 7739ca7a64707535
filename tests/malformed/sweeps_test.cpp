// Every sweep of sweeps/ is refused with exactly the errors that it announces.
#include "malformed/by_program.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar::malformed {
namespace {

const fs::path folder = fs::path(VISCOBAR_SOURCE_DIR) / "tests/malformed/sweeps";

class MalformedSweep : public testing::TestWithParam<fs::path> {};

TEST_P(MalformedSweep, GivesExactlyTheErrorsItAnnounces) {
  const Expectations expected = expectations_of(GetParam());
  std::vector<Diagnostic> found;
  try {
    plan_cases(read_sweep(GetParam(), expected.overrides), 1);
  } catch (const SceneError& error) {
    found = error.diagnostics;
  }
  expect_announced(found, expected);
}

INSTANTIATE_TEST_SUITE_P(Of, MalformedSweep, testing::ValuesIn(files_in(folder)), test_name);

using MalformedSweeps = ByProgram;

TEST_F(MalformedSweeps, EndTheProgramWithCode2AndTheErrorsAloneAndNothingWritten) {
  expect_errors_alone("sweep", folder);
}

}  // namespace
}  // namespace viscobar::malformed
