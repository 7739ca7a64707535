// Every sweep of sweeps.txt is refused with exactly the errors that it announces: by the library, and by the program.
#include "malformed/malformed_files.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar::malformed {
namespace {

class MalformedSweeps : public MalformedFiles {
 protected:
  MalformedSweeps() : MalformedFiles("sweeps.txt") {}
};

TEST_F(MalformedSweeps, GiveExactlyTheErrorsTheyAnnounce) {
  EXPECT_GT(cases_.size(), 70u);
  expect_refused([](const fs::path& file, const std::vector<std::string>& overrides) {
    plan_cases(read_sweep(file, overrides), 1);
  });
}

TEST_F(MalformedSweeps, EndTheProgramWithCode2AndTheErrorsAloneAndNothingWritten) { expect_errors_alone("sweep"); }

}  // namespace
}  // namespace viscobar::malformed
