// The folders are layers: what a file may include follows from the folder it is in. The table is the one of
// docs/internals/design.md, read off the #include lines of the sources themselves.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

/// A folder of src/ and of include/viscobar/, and what it may include besides itself: these, and what they may.
struct Room {
  std::string name;
  std::vector<std::string> above;
};

const std::vector<Room> rooms = {
    {"text", {}},
    {"scene", {}},
    {"discretisation", {}},
    {"dynamics", {"scene", "discretisation"}},
    {"run", {"dynamics"}},
    {"integration", {"run"}},
    {"schemes", {"run"}},
    {"characteristics", {"run"}},
    {"case", {"integration", "schemes", "characteristics", "text"}},
    {"studies", {"case"}},
    {"input", {"case"}},
    {"results", {"input"}},
    {"report", {"studies", "results"}},
    {"record", {"report"}},
    {"sweep", {"record"}},
    {"cli", {"sweep"}},
    {"testing", {"report"}},
};

std::map<std::string, std::set<std::string>> allowed_includes() {
  std::map<std::string, std::set<std::string>> allowed;
  for (const Room& room : rooms) {
    std::set<std::string>& all = allowed[room.name];
    for (const std::string& above : room.above) {
      all.insert(above);
      all.insert(allowed.at(above).begin(), allowed.at(above).end());
    }
  }
  return allowed;
}

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
  const auto allowed = allowed_includes();
  std::size_t seen = 0;
  for (const std::string root : {VISCOBAR_SOURCE_DIR "/src", VISCOBAR_SOURCE_DIR "/include/viscobar"}) {
    for_each_include(root, [&](const fs::path& file, std::string included) {
      if (included.starts_with("viscobar/")) included = included.substr(9);
      const std::string from = folder(fs::relative(file, root).string()), to = folder(included);
      if (!fs::exists(VISCOBAR_SOURCE_DIR "/src/" + to) || from == to || from == "viscobar.hpp") return;
      ++seen;
      ASSERT_TRUE(allowed.contains(from)) << file << " is in a folder that is not in the table";
      EXPECT_TRUE(allowed.at(from).contains(to)) << file << " includes " << included;
    });
  }
  EXPECT_GT(seen, 200u);
}

TEST(Layers, EveryFolderIsInTheTableAndHoldsNoMoreThanFortyFiles) {
  const auto allowed = allowed_includes();
  for (const std::string root : {VISCOBAR_SOURCE_DIR "/src", VISCOBAR_SOURCE_DIR "/include/viscobar"}) {
    std::map<fs::path, std::size_t> files;
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      if (entry.is_regular_file()) ++files[entry.path().parent_path()];
      if (entry.is_directory() && entry.path().parent_path() == root) {
        EXPECT_TRUE(allowed.contains(entry.path().filename())) << entry.path();
      }
    }
    for (const auto& [place, count] : files) EXPECT_LE(count, 40u) << place;
  }
}

TEST(Layers, AStudyHasOneNameInEveryLayer) {
  for (const std::string study : {"compare", "limit", "precision"}) {
    for (const std::string& file :
         {"include/viscobar/studies/" + study + "/" + study + ".hpp", "src/studies/" + study + "/" + study + ".cpp",
          "src/report/" + study + "/" + study + "_page.cpp", "src/cli/" + study + ".cpp"})
      EXPECT_TRUE(fs::exists(VISCOBAR_SOURCE_DIR "/" + file)) << file;
  }
}

TEST(Layers, PublicHeadersAreFew) {
  std::size_t headers = 0;
  for (const auto& entry : fs::recursive_directory_iterator(VISCOBAR_SOURCE_DIR "/include"))
    headers += entry.path().extension() == ".hpp";
  EXPECT_LE(headers, 49u);
}

TEST(Layers, PublicHeadersIncludeNoPrivateOnes) {
  for_each_include(VISCOBAR_SOURCE_DIR "/include", [&](const fs::path& file, const std::string& included) {
    EXPECT_FALSE(fs::exists(VISCOBAR_SOURCE_DIR "/src/" + included)) << file << " includes " << included;
  });
}

TEST(Layers, PublicHeadersIncludeNothingOfThirdParties) {
  const std::regex third_party(
      R"(^(sundials|cvode|ida|arkode|nvector|sunmatrix|sunlinsol|boost|hdf5|H5|toml|Eigen|fmt|CLI|nlohmann))");
  for_each_include(VISCOBAR_SOURCE_DIR "/include", [&](const fs::path& file, const std::string& included) {
    EXPECT_FALSE(std::regex_search(included, third_party)) << file << " includes " << included;
  });
}

TEST(Layers, AMethodOfSundialsIncludesTheLibraryThatItIsNamedAfterAlone) {
  const std::map<std::string, std::string> methods = {
      {"cvode.cpp", "cvode"}, {"ida.cpp", "ida"}, {"arkode.cpp", "arkode"}};
  for_each_include(VISCOBAR_SOURCE_DIR "/src/integration", [&](const fs::path& file, const std::string& included) {
    const auto own = methods.find(file.filename());
    if (own == methods.end()) return;
    for (const auto& [name, library] : methods) {
      if (library == own->second) continue;
      EXPECT_EQ(included.find(library), std::string::npos) << file << " includes " << included;
    }
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
