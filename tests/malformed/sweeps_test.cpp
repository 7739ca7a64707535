// Every sweep of sweeps/ is refused with exactly the errors that it announces.
#include "cli/command.hpp"
#include "malformed/expectations.hpp"
#include "viscobar/io/sweep_file.hpp"

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

class MalformedSweeps : public testing_cli::Command {};

TEST_F(MalformedSweeps, EndTheProgramWithCode2AndTheErrorsAloneAndNothingWritten) {
  for (const fs::path& file : files_in(folder)) {
    const Expectations expected = expectations_of(file);
    std::string arguments = "sweep --json -o out '" + file.string() + "'";
    for (const std::string& one : expected.overrides) arguments += " --set '" + one + "'";
    const testing_cli::Ended ended = viscobar(arguments);
    EXPECT_EQ(ended.code, 2) << file;
    EXPECT_EQ(ended.out, "") << file;
    EXPECT_EQ(static_cast<std::size_t>(std::count(ended.error.begin(), ended.error.end(), '\n')),
              expected.errors.size())
        << file << "\n"
        << ended.error;
    EXPECT_FALSE(fs::exists(directory_ / "out")) << file;
  }
}

}  // namespace
}  // namespace viscobar::malformed
