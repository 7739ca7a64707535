// Every scene of scenes/ is refused with exactly the errors that it announces: by the library, and by the program.
#include <unistd.h>

#include "cli/command.hpp"
#include "malformed/expectations.hpp"

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

std::string quoted(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

class MalformedScenes : public testing_cli::Command {};

TEST_F(MalformedScenes, EndTheProgramWithCode2AndTheErrorsAloneAndNothingWritten) {
  for (const fs::path& file : files_in(folder)) {
    const Expectations expected = expectations_of(file);
    std::string arguments = "run --json -o out " + quoted(file.string());
    for (const std::string& one : expected.overrides) arguments += " --set " + quoted(one);
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
