// Every scene of scenes.txt is refused with exactly the errors that it announces: by the library, and by the program.
#include "malformed/malformed_files.hpp"

namespace viscobar::malformed {
namespace {

class MalformedScenes : public MalformedFiles {
 protected:
  MalformedScenes() : MalformedFiles("scenes.txt") {}
};

TEST_F(MalformedScenes, GiveExactlyTheErrorsTheyAnnounce) {
  EXPECT_GT(cases_.size(), 500u);
  expect_refused([](const fs::path& file, const std::vector<std::string>& overrides) { read_scene(file, overrides); });
}

TEST_F(MalformedScenes, EndTheProgramWithCode2AndTheErrorsAloneAndNothingWritten) { expect_errors_alone("run"); }

}  // namespace
}  // namespace viscobar::malformed
