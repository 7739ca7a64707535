// Every line of command-lines.txt is refused with the words that it announces.
#include <sstream>

#include "cli/command.hpp"

namespace viscobar {
namespace {

namespace fs = std::filesystem;

class MalformedCommandLines : public testing_cli::Command {
 protected:
  MalformedCommandLines() {
    viscobar("new scene.toml");
    std::ofstream(directory_ / "sweep.toml") << "scene = \"scene.toml\"\n[vary]\nbar.viscosity = [0.1, 0.2]\n";
    std::ofstream(directory_ / "free.toml")
        << "[bar]\nlength = 1\n[initial]\ndisplacement = 0\nvelocity = 1\n[time]\nend = 1\n[mesh]\nelements = 4\n";
    std::ofstream(directory_ / "broken.toml") << "[bar\n";
    std::ofstream(directory_ / "at-zero.csv") << "t,u_left\n0,0\n";
    std::ofstream(directory_ / "sound.csv") << "t,u_left\n0,0\n1,0\n";
    std::ofstream(directory_ / "unknown.csv") << "time;u\n0;0\n1;0\n";
    fs::create_directory(directory_ / "mine");
    std::ofstream(directory_ / "mine/letter.txt") << "precious";
  }

  /// Every file below the directory, but for what the shell caught.
  std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(directory_))
      if (entry.path().filename() != "standard-error") found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    return found;
  }
};

// A line is "arguments | part of the message"; # begins a comment. Every one ends with code 2.
TEST_F(MalformedCommandLines, EndWithCode2AndTheWordsTheyAnnounceAndNothingWritten) {
  std::istringstream table(read_text(VISCOBAR_SOURCE_DIR "/tests/malformed/command-lines.txt"));
  const auto before = files();
  std::size_t count = 0;
  for (std::string line; std::getline(table, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    const std::size_t bar = line.rfind(" | ");
    ASSERT_NE(bar, line.npos) << line;
    const std::string arguments = line.substr(0, bar), words = line.substr(bar + 3);
    ASSERT_FALSE(words.empty()) << line;
    const testing_cli::Ended ended = viscobar(arguments);
    EXPECT_EQ(ended.code, 2) << line << "\n" << ended.error;
    EXPECT_EQ(ended.out, "") << line;
    EXPECT_NE(ended.error.find(words), std::string::npos) << line << "\n" << ended.error;
    EXPECT_EQ(files(), before) << line;
    ++count;
  }
  EXPECT_GT(count, 100u);
}

}  // namespace
}  // namespace viscobar
