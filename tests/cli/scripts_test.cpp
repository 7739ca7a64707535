// The scripts of examples/ that read the files of a sweep.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "cli/command.hpp"

namespace viscobar {
namespace {

class ReadSweep : public testing_cli::Command {
 protected:
  // Six rows, and two refused ones, whose error holds commas and quotes.
  ReadSweep() {
    viscobar("new scene.toml");
    std::ofstream(directory_ / "sweep.toml")
        << "title = \"Few\"\nscene = \"scene.toml\"\n[set]\nmethod.name = \"cvode\"\ntime.end = 1.0\n[vary]\n"
           "mesh.mass = [\"consistent\", \"redistributed\"]\nmesh.elements = [8, 16]\nbar.viscosity = [0.0, 0.1]\n";
    EXPECT_EQ(viscobar("sweep sweep.toml --quiet -o out").code, 1);
    std::ifstream rows(directory_ / "out/sweep.csv");
    std::string header;
    std::getline(rows, header);
    const auto place =
        std::count(header.begin(), header.begin() + static_cast<long>(header.find(",max_penetration")), ',');
    for (std::string row; std::getline(rows, row);) {
      if (row.find('"') != row.npos) continue;  // of a case that was refused
      std::istringstream cells(row);
      std::string cell;
      for (long k = 0; k <= place + 1; ++k) std::getline(cells, cell, ',');
      penetration_ = std::fmax(penetration_, std::stod(cell));
    }
  }

  void expect_read_by(const std::string& interpreter, const std::string& script) const {
    const std::string line = "cd '" + directory_.string() + "' && " + interpreter +
                             " '" VISCOBAR_SOURCE_DIR "/examples/" + script + "' out >script.txt 2>error.txt";
    ASSERT_EQ(std::system(line.c_str()), 0) << read_text(directory_ / "error.txt");
    const std::string printed = read_text(directory_ / "script.txt"), before = "largest penetration = ";
    EXPECT_EQ(printed.find("Few"), 0u) << printed;
    EXPECT_NE(printed.find(" seconds of 8 cases"), std::string::npos) << printed;
    EXPECT_NE(printed.find("failed: 2 "), std::string::npos) << printed;
    const std::size_t at = printed.find(before);
    ASSERT_NE(at, std::string::npos) << printed;
    EXPECT_NEAR(std::stod(printed.substr(at + before.size())), penetration_, 1e-14 * penetration_);  // 15 digits
  }

  double penetration_ = std::nan("");
};

TEST_F(ReadSweep, PythonReadsEveryFile) {
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-h5py is not installed";
  expect_read_by("/usr/bin/python3", "read_sweep.py");
}

TEST_F(ReadSweep, OctaveReadsEveryTable) {
  if (std::system("octave-cli --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "octave is not installed";
  expect_read_by("octave-cli -q", "read_sweep.m");
}

}  // namespace
}  // namespace viscobar
