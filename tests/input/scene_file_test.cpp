#include "viscobar/input/scene_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "input/described_scene.hpp"
#include "input/scene_keys.hpp"
#include "support/description.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;
using Overrides = std::vector<std::string>;

const fs::path root = VISCOBAR_SOURCE_DIR;

constexpr const char* small_scene = R"toml([bar]
length = 2.0

[initial]
displacement = "x*(1-x)"
velocity = 0

[time]
end = 4.0

[mesh]
elements = 8
)toml";

SceneFile small(const Overrides& overrides = {}, const std::string& more = "") {
  return parse_scene(small_scene + more, "small.toml", overrides);
}

std::vector<Diagnostic> errors_of(const std::string& text, const Overrides& overrides = {}) {
  try {
    parse_scene(text, "scene.toml", overrides);
  } catch (const SceneError& error) {
    return error.diagnostics;
  }
  return {};
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

std::string test_name(const testing::TestParamInfo<fs::path>& info) {
  std::string name = info.param.stem().string();
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

class Example : public testing::TestWithParam<fs::path> {};

TEST_P(Example, RunsByEveryMethodButThoseThatCannotTakeItsMassOrMesh) {
  const Case run = read_scene(GetParam()).run;
  const auto cannot = [&](MethodName method) {
    const bool massless = run.mass == Mass::redistributed;
    if (!run.scene.chain.empty() && method == MethodName::finite_difference) return true;
    if (has_stops(run.scene))
      return method != MethodName::cvode && method != MethodName::ida && method != MethodName::arkode &&
             method != MethodName::odeint;
    if (method == MethodName::rigid) return run.scene.span.has_value();
    if (run.scene.section && method == MethodName::finite_difference) return true;
    if (method == MethodName::characteristics) return run.scene.bar.viscosity > 0.0 || run.scene.span.has_value();
    if (method == MethodName::exponential) return run.elements >= Exponential::most_unknowns;
    const bool differential = method == MethodName::cvode || method == MethodName::odeint;
    return massless && (method == MethodName::finite_difference || (differential && run.scene.bar.viscosity == 0.0));
  };
  for (const MethodName method : all_methods) {
    const Overrides overrides{"method.name=" + std::string(name(method))};
    if (cannot(method))
      EXPECT_THROW(read_scene(GetParam(), overrides), SceneError) << name(method);
    else
      EXPECT_EQ(read_scene(GetParam(), overrides).run.method, method);
  }
}

INSTANTIATE_TEST_SUITE_P(SceneFile, Example, testing::ValuesIn(files_in(root / "examples/scenes")), test_name);

TEST(SceneFile, GivesTheFallbacksOfKeysThatAreAbsent) {
  const Case run = small().run;
  EXPECT_EQ(run.scene.title, "");
  EXPECT_EQ(run.scene.bar.density, 1.0);
  EXPECT_EQ(run.scene.bar.modulus, 1.0);
  EXPECT_EQ(run.scene.bar.viscosity, 0.0);
  EXPECT_TRUE(std::holds_alternative<Free>(run.scene.left));
  EXPECT_TRUE(std::holds_alternative<Free>(run.scene.right));
  EXPECT_FALSE(run.scene.span);
  EXPECT_FALSE(run.scene.load);
  EXPECT_FALSE(run.mass);
  EXPECT_FALSE(run.epsilon);
  EXPECT_FALSE(run.restitution);
  EXPECT_TRUE(run.automatic);
  EXPECT_EQ(run.tolerance.relative, 1e-6);
  EXPECT_FALSE(run.tolerance.absolute);
  EXPECT_FALSE(run.step);
  EXPECT_EQ(run.start, Start::first_order);
  EXPECT_EQ(run.impact, Impact::paoli_schatzman);
  EXPECT_EQ(run.output_every, 4.0 / 100);
}

TEST(SceneFile, GivesEveryKeyItsPlaceInTheCase) {
  const Case run = parse_scene(R"(title = "all of them, größer"
[bar]
length = 2
density = 3.0
modulus = 5.0
viscosity = 7.0
[left]
kind = "obstacle"
gap = 0.5
[right]
kind = "fixed"
[span]
gap = 11.0
[initial]
displacement = "x"
velocity = 13
[load]
profile = "x"
history = "t"
[time]
end = 17.0
[mesh]
elements = 19
mass = "lumped"
[contact]
epsilon = 1e-3
restitution = 0.25
[method]
name = "fully_discrete"
relative_tolerance = 1e-4
absolute_tolerance = 1e-5
step = 0.125
start = "second_order"
impact = "moreau"
[output]
every = 0.75
)",
                               "all.toml")
                       .run;
  EXPECT_EQ(run.scene.title, "all of them, größer");
  EXPECT_EQ(run.scene.bar.length, 2.0);
  EXPECT_EQ(run.scene.bar.density, 3.0);
  EXPECT_EQ(run.scene.bar.modulus, 5.0);
  EXPECT_EQ(run.scene.bar.viscosity, 7.0);
  EXPECT_EQ(std::get<Obstacle>(run.scene.left).gap, 0.5);
  EXPECT_TRUE(is_fixed(run.scene.right));
  ASSERT_TRUE(run.scene.span);
  EXPECT_EQ(run.scene.span->gap, 11.0);
  EXPECT_EQ(run.scene.displacement(1.5), 1.5);
  EXPECT_EQ(run.scene.velocity(1.5), 13.0);
  const auto& load = std::get<SeparableLoad>(*run.scene.load);
  EXPECT_EQ(load.profile(1.5), 1.5);
  EXPECT_EQ(load.history(2.5), 2.5);
  EXPECT_EQ(run.end, 17.0);
  EXPECT_EQ(run.elements, 19u);
  EXPECT_EQ(run.mass, Mass::lumped);
  EXPECT_EQ(run.epsilon, 1e-3);
  EXPECT_EQ(run.restitution, 0.25);
  EXPECT_EQ(run.method, MethodName::fully_discrete);
  EXPECT_EQ(run.tolerance.relative, 1e-4);
  EXPECT_EQ(run.tolerance.absolute, 1e-5);
  EXPECT_EQ(run.step, 0.125);
  EXPECT_EQ(run.start, Start::second_order);
  EXPECT_EQ(run.impact, Impact::moreau);
  EXPECT_EQ(run.output_every, 0.75);
}

TEST(SceneFile, KnowsEveryNameOfAMassAndAMethod) {
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed})
    EXPECT_EQ(small({"mesh.mass=" + std::string(name(mass))}).run.mass, mass);
  for (const MethodName method : all_methods)
    EXPECT_EQ(small({"method.name=" + std::string(name(method)), "method.step=0.1"}).run.method, method);
}

template <class Kind>
bool load_is(const std::string& keys) {
  const auto load = small({}, "[load]\n" + keys).run.scene.load;
  return load && std::holds_alternative<Kind>(*load);
}

TEST(SceneFile, MakesTheNarrowestLoad) {
  EXPECT_TRUE(load_is<SteadyLoad>("density = 2"));
  EXPECT_TRUE(load_is<SteadyLoad>("density = \"cos(2*x)\""));
  EXPECT_TRUE(load_is<SeparableLoad>("density = \"sin(t)\""));
  EXPECT_TRUE(load_is<GeneralLoad>("density = \"sin(t + 2*x)\""));
  EXPECT_TRUE(load_is<SeparableLoad>("density = \"sin(t)*cos(2*x)\""));
  EXPECT_TRUE(load_is<SeparableLoad>("profile = 2\nhistory = \"sin(t)\""));
  EXPECT_TRUE(load_is<SteadyLoad>("profile = \"x\"\nhistory = 3"));
}

TEST(SceneFile, MakesNoLoadOfZero) {
  for (const char* keys : {"density = 0", "density = 0.0", "density = \"0\"", "density = \"2 - 2\"",
                           "profile = 0\nhistory = \"t\"", "profile = \"x\"\nhistory = 0"})
    EXPECT_FALSE(small({}, std::string("[load]\n") + keys).run.scene.load) << keys;
}

TEST(SceneFile, KeepsTheValueOfALoadInWhateverKind) {
  const auto load = [](const std::string& keys) { return *small({}, "[load]\n" + keys).run.scene.load; };
  EXPECT_EQ(std::get<SteadyLoad>(load("profile = \"x\"\nhistory = 3")).profile(2.0), 6.0);
  const auto in_time = std::get<SeparableLoad>(load("density = \"t\""));
  EXPECT_EQ(in_time.profile(2.0) * in_time.history(3.0), 3.0);
  EXPECT_EQ(std::get<GeneralLoad>(load("density = \"x - t\"")).density(2.0, 3.0), -1.0);
}

TEST(SceneFile, TakesOverridesAsTomlOrElseAsText) {
  EXPECT_EQ(small({"time.end=5"}).run.end, 5.0);
  EXPECT_EQ(small({"time.end = 5.5 "}).run.end, 5.5);
  EXPECT_EQ(small({"method.name=ida"}).run.method, MethodName::ida);
  EXPECT_EQ(small({"method.name=\"ida\""}).run.method, MethodName::ida);
  EXPECT_EQ(small({"initial.velocity=-x*(1-x)"}).run.scene.velocity(3.0), 6.0);
  EXPECT_EQ(small({"initial.velocity=0.5"}).run.scene.velocity(3.0), 0.5);
  EXPECT_EQ(small({"initial.velocity=x==1 ? 2 : 3"}).run.scene.velocity(1.0), 2.0);
  EXPECT_EQ(small({"title=a bar, no more"}).run.scene.title, "a bar, no more");
}

TEST(SceneFile, TakesOverridesInTheirOrder) { EXPECT_EQ(small({"time.end=5", "time.end=6"}).run.end, 6.0); }

TEST(SceneFile, LetsOverridesAddTables) {
  const Case run = small({"left.kind=obstacle", "left.gap=0.5", "contact.epsilon=1e-3"}).run;
  EXPECT_EQ(std::get<Obstacle>(run.scene.left).gap, 0.5);
  EXPECT_EQ(run.epsilon, 1e-3);
}

TEST(SceneFile, ForgetsTheErrorOfAValueThatAnOverrideReplaces) {
  std::string text = small_scene;
  text.replace(text.find("2.0"), 3, "-2.0");
  EXPECT_EQ(errors_of(text).size(), 1u);
  EXPECT_EQ(parse_scene(text, "scene.toml", Overrides{"bar.length=3"}).run.scene.bar.length, 3.0);
}

TEST(SceneFile, RefusesAnOverrideThatIsNotUtf8) {
  const auto found = errors_of(small_scene, {"title=\xff"});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].text(), "--set:1:1: is not UTF-8 text");
}

// As people write numbers. TOML wants digits on both sides of a point, and no zeros in front.
TEST(SceneFile, OverridesTakeNumbersAsPeopleWriteThem) {
  const std::pair<const char*, double> numbers[] = {{".25", 0.25}, {"2.", 2.0},   {"+.5", 0.5},  {"1.e-2", 0.01},
                                                    {"007", 7.0},  {"00.5", 0.5}, {".5e1", 5.0}, {"1_0", 10.0}};
  for (const auto& [text, number] : numbers) {
    EXPECT_EQ(small({fmt::format("bar.viscosity={}", text)}).run.scene.bar.viscosity, number) << text;
    const SceneFile gap = small({"left.kind=obstacle", fmt::format("left.gap={}", text)});  // a number, or a formula
    EXPECT_EQ(std::get<Obstacle>(gap.run.scene.left).gap, number) << text;
    EXPECT_FALSE(std::holds_alternative<std::string>(*value_of(gap.values, "left.gap"))) << text;
  }
  EXPECT_EQ(small({"output.gauges=[.25, 1., 007.5e-1]"}).run.gauges, (std::vector{0.25, 1.0, 0.75}));
  EXPECT_EQ(small({"mesh.elements=012"}).run.elements, 12u);
  // Text in quotes, and what is no number, stays text.
  EXPECT_EQ(small({"title=\"no. 007\""}).run.scene.title, "no. 007");
  EXPECT_EQ(small({"title=v.2"}).run.scene.title, "v.2");
  EXPECT_EQ(small({"initial.velocity=.5*x"}).run.scene.velocity(0.5), 0.25);
  EXPECT_THROW(small({"bar.viscosity=.5.5"}), SceneError);
  EXPECT_THROW(small({"bar.viscosity=."}), SceneError);
}

TEST(SceneFile, ReadsTheSameWithWindowsLineEndsAndByteOrderMark) {
  std::string text = "\xEF\xBB\xBF";
  for (const char* c = small_scene; *c; ++c) {
    if (*c == '\n') text += '\r';
    text += *c;
  }
  EXPECT_EQ(parse_scene(text, "scene.toml").description(), small().description());
}

TEST(SceneFile, ThatIsEmptyLacksEveryRequiredKeyAtItsBeginning) {
  std::size_t required = 0;
  for (const SceneKey& key : scene_keys()) required += key.presence == Presence::required ? 1 : 0;
  const auto found = errors_of("");
  EXPECT_EQ(found.size(), required + 1);  // and something that moves the bar
  for (const Diagnostic& one : found) {
    EXPECT_EQ(one.line, 1u);
    EXPECT_EQ(one.column, 1u);
  }
}

TEST(SceneFile, ThatCannotBeReadIsOneError) {
  for (const auto& [path, words] :
       {std::pair{root / "no such scene.toml", ": does not exist"}, {root, ": cannot be read: "}}) {
    try {
      read_scene(path, Overrides{"foo"});
      FAIL() << path;
    } catch (const SceneError& error) {
      ASSERT_EQ(error.diagnostics.size(), 1u);
      EXPECT_TRUE(std::string(error.what()).starts_with(path.string() + words)) << error.what();
    }
  }
}

TEST(SceneFile, ErrorsReadAsFileLineColumnKeyMessage) {
  std::string text = small_scene;
  text.replace(text.find("2.0"), 3, "0");
  try {
    parse_scene(text + "[output]\nevery = 0\n", "dir/scene.toml");
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_STREQ(error.what(),
                 "dir/scene.toml:2:10: bar.length: must be positive, is 0\n"
                 "dir/scene.toml:14:9: output.every: must be positive, is 0");
  }
}

TEST(SceneFile, DescribesEveryKeyAsUnderstood) {
  const auto description =
      nlohmann::json::parse(small({"load.density=sin(t)", "mesh.mass=lumped", "title=\"a \\\"b\\\"\""}).description());
  const auto expected = nlohmann::json::parse(R"json({
    "title": "a \"b\"",
    "bar": {"length": 2.0, "density": 1.0, "modulus": 1.0, "viscosity": 0.0},
    "left": {"kind": "free"}, "right": {"kind": "free"},
    "initial": {"displacement": "x*(1-x)", "velocity": 0.0},
    "load": {"density": "sin(t)"},
    "time": {"end": 4.0},
    "mesh": {"elements": 8, "grading": 1.0, "mass": "lumped"},
    "method": {"name": "automatic", "relative_tolerance": 1e-6,
               "error_control": "global", "stepper": "automatic", "start": "first_order",
               "impact": "paoli_schatzman"},
    "output": {"every": 0.04}})json");
  EXPECT_EQ(description, expected) << description.dump(2);
}

TEST(SceneFile, IsRestoredByItsDescription) {
  for (const fs::path& file : files_in(root / "examples/scenes")) {
    const std::string description = read_scene(file).description();
    EXPECT_EQ(parse_scene("", "empty.toml", overrides_of(description)).description(), description);
  }
}

TEST(SceneKeys, BelongToTheTablesInTheirOrder) {
  std::vector<std::string_view> tables;
  for (const SceneKey& key : scene_keys())
    if (!key.table().empty() && (tables.empty() || tables.back() != key.table())) tables.push_back(key.table());
  EXPECT_TRUE(std::equal(tables.begin(), tables.end(), scene_tables().begin(), scene_tables().end()));
}

TEST(SceneKeys, AreEachFoundNearTheirNameWithTwoLettersExchanged) {
  for (const SceneKey& key : scene_keys()) {
    std::string misspelt(key.leaf());
    std::swap(misspelt[1], misspelt[2]);
    if (misspelt == key.leaf()) std::swap(misspelt[0], misspelt[1]);
    const SceneKey* nearest = nearest_scene_key(key.table(), misspelt);
    ASSERT_NE(nearest, nullptr) << misspelt;
    EXPECT_EQ(nearest->name, key.name) << misspelt;
  }
}

}  // namespace
}  // namespace viscobar
