// <viscobar/viscobar.hpp> is the whole library: every public header but those that need GoogleTest.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "viscobar/viscobar.hpp"

namespace {

TEST(Umbrella, IncludesEveryPublicHeader) {
  const std::filesystem::path include = VISCOBAR_SOURCE_DIR "/include";
  std::stringstream text;
  text << std::ifstream(include / "viscobar/viscobar.hpp").rdbuf();
  for (const auto& entry : std::filesystem::recursive_directory_iterator(include / "viscobar")) {
    const std::string header = std::filesystem::relative(entry.path(), include).string();
    if (!header.ends_with(".hpp") || header == "viscobar/viscobar.hpp" || header.starts_with("viscobar/testing/"))
      continue;
    EXPECT_NE(text.str().find("#include \"" + header + "\""), std::string::npos) << header;
  }
}

}  // namespace
