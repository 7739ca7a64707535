// Every scene of scenes/ is refused with exactly the errors that it announces: by the library, and by the program.
#include "malformed/by_program.hpp"

namespace viscobar::malformed {
namespace {

const fs::path folder = fs::path(VISCOBAR_SOURCE_DIR) / "tests/malformed/scenes";

class MalformedScene : public testing::TestWithParam<fs::path> {};

TEST_P(MalformedScene, GivesExactlyTheErrorsItAnnounces) {
  const Expectations expected = expectations_of(GetParam());
  std::vector<Diagnostic> found;
  try {
    parse_scene(content(GetParam()), "scene.toml", expected.overrides);
  } catch (const SceneError& error) {
    found = error.diagnostics;
  }
  expect_announced(found, expected);
}

INSTANTIATE_TEST_SUITE_P(Of, MalformedScene, testing::ValuesIn(files_in(folder)), test_name);

using MalformedScenes = ByProgram;

TEST_F(MalformedScenes, EndTheProgramWithCode2AndTheErrorsAloneAndNothingWritten) {
  expect_errors_alone("run", folder);
}

}  // namespace
}  // namespace viscobar::malformed
