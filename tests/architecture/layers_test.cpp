// The folders are layers: what a file may include follows from the folder it is in. The table is the one of
// docs/design.md, read off the #include lines of the sources themselves.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

namespace {

namespace fs = std::filesystem;

const std::map<std::string, std::set<std::string>> allowed = {
    {"scene", {}},
    {"discretisation", {}},
    {"dynamics", {"scene", "discretisation"}},
    {"integration", {"scene", "discretisation", "dynamics"}},
    {"schemes", {"scene", "discretisation", "dynamics"}},
    {"characteristics", {"scene", "discretisation", "dynamics"}},
    {"analysis", {"scene", "discretisation", "dynamics", "integration", "schemes", "characteristics"}},
    {"io", {"scene", "discretisation", "dynamics", "integration", "schemes", "characteristics", "analysis"}},
    {"cli", {"scene", "discretisation", "dynamics", "integration", "schemes", "characteristics", "analysis", "io"}},
};

template <class Visit>
void for_each_include(const fs::path& root, Visit visit) {
  const std::regex include(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path());
    std::string line;
    while (std::getline(file, line)) {
      std::smatch match;
      if (std::regex_search(line, match, include)) visit(entry.path(), match[1].str());
    }
  }
}

std::string folder(const std::string& path) { return path.substr(0, path.find('/')); }

TEST(Layers, EachFolderIncludesOnlyFoldersBelowIt) {
  std::size_t seen = 0;
  for (const std::string root : {VISCOBAR_SOURCE_DIR "/src", VISCOBAR_SOURCE_DIR "/include/viscobar"}) {
    for_each_include(root, [&](const fs::path& file, std::string included) {
      if (included.starts_with("viscobar/")) included = included.substr(9);
      const std::string from = folder(fs::relative(file, root).string()), to = folder(included);
      if (!allowed.contains(from) || !allowed.contains(to) || from == to) return;
      ++seen;
      EXPECT_TRUE(allowed.at(from).contains(to)) << file << " includes " << included;
    });
  }
  EXPECT_GT(seen, 20u);
}

TEST(Layers, PublicHeadersIncludeNothingOfThirdParties) {
  const std::regex third_party(
      R"(^(sundials|cvode|ida|arkode|nvector|sunmatrix|sunlinsol|boost|hdf5|H5|toml|muParser|Eigen|fmt|CLI|nlohmann))");
  for_each_include(VISCOBAR_SOURCE_DIR "/include", [&](const fs::path& file, const std::string& included) {
    EXPECT_FALSE(std::regex_search(included, third_party)) << file << " includes " << included;
  });
}

TEST(Layers, OnlyIntegrationKnowsSundials) {
  const std::regex library(R"(^(sundials|cvode|ida|arkode)/.*\.h$)");
  for_each_include(VISCOBAR_SOURCE_DIR "/src", [&](const fs::path& file, const std::string& included) {
    if (!std::regex_search(included, library) || included.ends_with("sundials_version.h") ||
        included.ends_with("sundials_config.h"))
      return;
    EXPECT_NE(file.string().find("/src/integration/"), std::string::npos) << file << " includes " << included;
  });
}

}  // namespace
