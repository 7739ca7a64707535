// A class stands for an idea. One with many public functions stands for several.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <string>

namespace {

namespace fs = std::filesystem;

// Code without comments, literals and lines of the preprocessor.
std::string bare(const std::string& code) {
  static const std::regex noise(R"re(//[^\n]*|#[^\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])+')re");
  return std::regex_replace(code, noise, " ");
}

// True if a member's declaration, without what stands in its brackets, is that of a function that somebody wrote.
bool is_function(std::string member) {
  member = std::regex_replace(member, std::regex(R"(operator[^(]*)"), "operator");
  for (std::string before; before != member;) {
    before = member;
    member = std::regex_replace(member, std::regex("<[^<>]*>"), "");
  }
  if (std::regex_search(member, std::regex(R"(^\s*(using|typedef|friend|static_assert|struct|class|enum|union)\b)")) ||
      std::regex_search(member, std::regex(R"(=\s*(default|delete)\s*$)")))
    return false;
  return member.find('(') < member.find('=');
}

// Public functions by the names of the classes in some bare code. Constructors and operators count.
std::map<std::string, std::size_t> public_functions(const std::string& code) {
  static const std::regex head(R"((\w+\s+)?\b(class|struct)\s+(\w+)(?:\s+final)?\s*(?::[^;{()]*)?\{)");
  std::map<std::string, std::size_t> all;
  for (std::sregex_iterator found(code.begin(), code.end(), head), none; found != none; ++found) {
    if ((*found)[1].str().starts_with("enum")) continue;
    bool is_public = (*found)[2] == "struct";
    std::size_t& count = all[(*found)[3]];
    std::string member;
    int depth = 0;
    const auto end_member = [&] {
      count += is_public && is_function(member);
      member.clear();
    };
    for (std::size_t i = found->position() + found->length(); i < code.size() && depth >= 0; ++i) {
      const char c = code[i];
      const bool opens = c == '{' || c == '(', closes = c == '}' || c == ')';
      if (closes) --depth;
      if (depth == 0 && c == ';') {
        end_member();
      } else if (depth == 0 && c == ':' &&
                 std::regex_match(member, std::regex(R"(\s*(public|private|protected)\s*)"))) {
        is_public = member.find("public") != member.npos;
        member.clear();
      } else if (depth == 0) {
        member += c;
        // A body ends a member, but not the braces of one that a constructor initialises.
        const auto next = std::find_if_not(code.begin() + static_cast<std::ptrdiff_t>(i) + 1, code.end(),
                                           [](unsigned char one) { return std::isspace(one); });
        if (c == '}' && next != code.end() && *next != ',' && *next != '{' && *next != ';') end_member();
      }
      if (opens) ++depth;
    }
  }
  return all;
}

TEST(Classes, PublicFunctionsAreCounted) {
  const std::string code = bare(R"(
    template <class T> class A : public B<T> {
     public:
      enum class Kind { one, two };
      A(int a) : a_{a}, b_(a) { f(a); }  // g();
      A(const A&) = delete;
      bool operator<=(const A& other) const { return f(1) <= other.f(1); }
      template <class Use> void each(Use&& use) const;
      std::function<bool(int)> stop;
      double c = f(1);
      struct Inner { int inner() const; int other(); };
     private:
      int f(int a) const;
      int a_;
    };)");
  EXPECT_EQ(public_functions(code), (std::map<std::string, std::size_t>{{"A", 3}, {"Inner", 2}}));
}

TEST(Classes, HaveTwentyFivePublicFunctionsAtMost) {
  std::size_t classes = 0;
  for (const std::string root : {VISCOBAR_SOURCE_DIR "/src", VISCOBAR_SOURCE_DIR "/include/viscobar"})
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      if (!entry.path().string().ends_with("pp")) continue;
      std::ifstream file(entry.path());
      const std::string code{std::istreambuf_iterator<char>(file), {}};
      for (const auto& [name, count] : public_functions(bare(code))) {
        ++classes;
        EXPECT_LE(count, 25u) << name << " in " << entry.path();
      }
    }
  EXPECT_GT(classes, 400u);
}

}  // namespace
