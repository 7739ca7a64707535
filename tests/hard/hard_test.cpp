// Every hard scene by every method: right within the tolerance that its oracles derive, refused, or stopped with the
// error that the catalogue names. Never a wrong answer in silence, a hang or a crash.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cctype>

#include "hard/hard_run.hpp"

namespace viscobar::hard {
namespace {

struct Parameter {
  HardScene scene;
  MethodName method;
};
void PrintTo(const Parameter& parameter, std::ostream* out) { *out << parameter.scene.name; }

class Hard : public testing::TestWithParam<Parameter> {};

TEST_P(Hard, IsRightOrNamesItsError) {
  const auto& [scene, method] = GetParam();
  if (scene.slow) GTEST_SKIP() << "long: measure_stability runs it";
  for (const Mass mass : masses_for(scene, method)) {
    const Outcome outcome = run_guarded(scene, method, mass);
    const auto wrong = complaint(scene, method, outcome);
    EXPECT_FALSE(wrong.has_value()) << name(mass) << ": " << wrong.value_or("");
  }
}

std::vector<Parameter> everything() {
  std::vector<Parameter> list;
  for (const HardScene& scene : catalogue())
    for (const MethodName method : methods_for(scene)) list.push_back({scene, method});
  return list;
}

std::string parameter_name(const testing::TestParamInfo<Parameter>& info) {
  std::string text = fmt::format("{}__{}", info.param.scene.name, name(info.param.method));
  for (char& c : text)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return text;
}

INSTANTIATE_TEST_SUITE_P(Scenes, Hard, testing::ValuesIn(everything()), parameter_name);

TEST(HardCatalogue, HasSixtyScenesOrMoreAndNoNameTwice) {
  const auto scenes = catalogue();
  EXPECT_GE(scenes.size(), 60u);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(scenes[i].name, scenes[j].name);
}

}  // namespace
}  // namespace viscobar::hard
