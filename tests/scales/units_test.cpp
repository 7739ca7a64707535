// The unit of length, mass or time is nobody's business: whatever powers of two they are multiplied by, every digit of
// every number and every word of an answer stays.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>

#include "cli/command.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {
namespace {

using nlohmann::json;

/// Powers of two.
struct Units {
  int length = 0, mass = 0, time = 0;
};
struct Dimension {
  int length = 0, mass = 0, time = 0;
  int shift(const Units& units) const { return length * units.length + mass * units.mass + time * units.time; }
};
constexpr Dimension a_length{1, 0, 0}, a_time{0, 0, 1}, a_velocity{1, 0, -1}, a_stress{-1, 1, -2}, none{};
constexpr Dimension an_energy{0, 1, -2};  // of a cross-section

class RandomText {
 public:
  /// `plain`: no numerical keys, no obstacle along the span, ends to which nothing is done; the modulus in proportion.
  explicit RandomText(unsigned seed, bool plain = false, double stiffer = 1.0)
      : seed_(seed), plain_(plain), stiffer_(stiffer) {}

  /// The same scene in any units.
  std::string in(const Units& units) {
    random_.seed(seed_);
    units_ = units;
    text_.clear();
    write();
    return text_;
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  bool coin(double share = 0.5) { return uniform(0.0, 1.0) < share; }
  std::size_t pick(std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_); }

  std::string number(double value, const Dimension& of) {
    return fmt::format("{}", std::ldexp(value, of.shift(units_)));
  }
  std::string shape(double size, const Dimension& of, const std::string& s) {
    return fmt::format("{}*({}+{}*cos({}*pi*{}))", number(size, of), uniform(-1.0, 0.0), uniform(-1.0, 1.0),
                       1 + pick(3), s);
  }

  void write() {
    // A bar of rho = E = 1 that is as long as that, on purpose of no round length.
    const double length = uniform(0.5, 8.0), density = uniform(0.5, 2.0), modulus = uniform(0.5, 2.0);
    const double crossing = length * std::sqrt(density / modulus), viscosities[] = {0.0, 0.01, 0.1, 1.0};
    const double viscosity = viscosities[pick(4)] * modulus * crossing, end = uniform(1.0, 3.0) * crossing;
    const std::string s = fmt::format("(x/{})", number(length, a_length));
    const auto add = [&](const std::string& line) { text_ += line + "\n"; };
    add("[bar]\nlength = " + number(length, a_length));
    add("density = " + number(density, {-3, 1, 0}));
    add("modulus = " + number(stiffer_ * modulus, a_stress));
    add("viscosity = " + number(viscosity, {-1, 1, -1}));
    const bool span = coin(0.2) && !plain_;
    bool meets = false, mounted = false;
    for (const char* side : {"left", "right"}) {
      const std::size_t kind = pick(span ? 2 : 4);
      add(fmt::format("[{}]\nkind = \"{}\"", side, kind >= 2 ? "obstacle" : kind == 1 ? "fixed" : "free"));
      const auto wave = [&](double size, const Dimension& of) {
        return fmt::format("{}*(1-cos({}*(t/{})))", number(size, of), 1 + pick(4), number(crossing, a_time));
      };
      if (kind == 1 && !span && coin(0.3) && !plain_) add("motion = \"" + wave(0.1 * length, a_length) + '"');
      if (kind != 1 && coin(0.3) && !plain_) add("force = \"" + wave(uniform(-0.5, 0.5) * modulus, a_stress) + '"');
      if (kind != 1 && coin(0.2) && !plain_)
        mounted = true, add("stiffness = " + number(modulus / length, {-2, 1, -2}));
      if (kind != 1 && coin(0.2) && !plain_)
        add("dashpot = " + number(uniform(0.2, 2.0) * std::sqrt(modulus * density), {-2, 1, -1}));
      if (kind < 2) continue;
      meets = true;
      const std::string gap = number(uniform(0.8, 1.2) * length, a_length);
      add(coin(0.7) || span || plain_ ? "gap = " + gap : "gap = \"" + gap + '+' + wave(0.1 * length, a_length) + '"');
      if (coin()) add("side = \"above\"");
    }
    if (span) {
      const char* sides[] = {"below", "above", "both"};
      add("[span]\ngap = " + number(uniform(0.8, 1.2) * length, a_length));
      add(fmt::format("side = \"{}\"", sides[pick(3)]));
    }
    add("[initial]\ndisplacement = \"" + shape(0.3 * length, a_length, s) + '"');
    add("velocity = \"" + shape(length / crossing, a_velocity, s) + '"');
    if (coin(0.3)) {
      add("[load]\nprofile = \"" + shape(modulus / length, {-2, 1, -2}, s) + '"');
      if (coin())
        add(fmt::format("history = \"sin(3*(t/{}))\"", number(crossing, a_time)));
      else
        add("history = 1");
    }
    add("[time]\nend = " + number(end, a_time));
    add("[output]\nevery = " + number(end / 20.0, a_time));
    if (plain_) return;
    const char* methods[] = {"automatic",       "cvode",          "ida",         "arkode",           "odeint", "rigid",
                             "characteristics", "fully_discrete", "exponential", "finite_difference"};
    std::string method = methods[pick(10)];
    if ((method == "rigid" && span) || (method == "characteristics" && (span || mounted || viscosity > 0.0)))
      method = "automatic";
    const std::size_t elements = 5 + pick(10);
    add(fmt::format("[mesh]\nelements = {}", elements));
    const char* masses[] = {"consistent", "lumped", "fourth_order"};
    if (coin()) add(fmt::format("mass = \"{}\"", masses[pick(method == "finite_difference" ? 2 : 3)]));
    add("[contact]");
    if (coin())
      add("epsilon = " + number(std::exp2(-4.0 - 8.0 * uniform(0.0, 1.0)) * length / modulus * (meets ? 1.0 : length),
                                meets ? Dimension{2, -1, 2} : Dimension{3, -1, 2}));
    if (coin()) add(fmt::format("restitution = {}", 0.5 * static_cast<double>(pick(3))));
    add(fmt::format("[method]\nname = \"{}\"", method));
    if (coin(0.3)) add("step = " + number(crossing / static_cast<double>(elements) / 16.0, a_time));
  }

  unsigned seed_;
  bool plain_;
  double stiffer_;
  std::mt19937 random_;
  Units units_;
  std::string text_;
};

const std::map<std::string, Dimension>& known() {
  static const std::map<std::string, Dimension> dimensions = {{"reached_time", a_time},
                                                              {"max_penetration", a_length},
                                                              {"time_in_contact", a_time},
                                                              {"impulse", {-1, 1, -1}},
                                                              {"max_reaction", a_stress},
                                                              {"initial", an_energy},
                                                              {"final", an_energy},
                                                              {"dissipated", an_energy},
                                                              {"work", an_energy},
                                                              {"steps", none},
                                                              {"events", none},
                                                              {"closings", none},
                                                              {"predicted_penetration", a_length},
                                                              {"speed", a_velocity},
                                                              {"spacing", a_length},
                                                              {"effective_mass", {-2, 1, 0}},
                                                              {"damping_ratio", none},
                                                              {"difference_to_scheme", a_length},
                                                              {"difference_to_rigid", a_length}};
  return dimensions;
}

std::string words(const std::string& text) {
  static const std::regex numbers(R"([-+]?[0-9]+(\.[0-9]+)?([eE][-+]?[0-9]+)?)");
  return std::regex_replace(text, numbers, "#");
}

bool of_the_clock(const std::string& key) {
  return key.ends_with("seconds") || key == "versions" || key == "platform" || key == "core_share" || key == "files" ||
         key == "crc64" || key == "checksums";
}

/// Without the remark on a busy machine, which comes and goes.
nlohmann::json of_the_scene(nlohmann::json said) {
  if (said.contains("remarks"))
    std::erase_if(said["remarks"].get_ref<json::array_t&>(),
                  [](const json& remark) { return remark.get<std::string>().starts_with("Other work"); });
  return said;
}

/// Expects that b is a in units that are larger by powers of two. Numbers under one key have one dimension.
class Same {
 public:
  explicit Same(const Units& units) : units_(units) {}

  void expect(const json& a, const json& b, const std::string& key) {
    ASSERT_EQ(a.is_number(), b.is_number()) << key;
    if (a.is_number()) return expect(a.get<double>(), b.get<double>(), key);
    ASSERT_EQ(a.type(), b.type()) << key;
    if (a.is_string()) {
      // The files that were read have other names.
      const auto told = [&](const json& text) {
        const std::string all = text.get<std::string>();
        return key == "data" ? all.substr(std::min(all.find(": "), all.size())) : all;
      };
      EXPECT_EQ(words(told(a)), words(told(b))) << key;
    } else if (a.is_structured()) {
      ASSERT_EQ(a.size(), b.size()) << key << "\n" << a << "\n" << b;
      for (auto i = a.begin(), j = b.begin(); i != a.end(); ++i, ++j) {
        ASSERT_TRUE(!a.is_object() || i.key() == j.key());
        if (!a.is_object())
          expect(*i, *j, key);
        else if (!of_the_clock(i.key()))
          expect(*i, *j, i.key());
      }
    } else {
      EXPECT_EQ(a, b) << key;
    }
  }

  void expect(double a, double b, const std::string& key) {
    int exponent_a = 0, exponent_b = 0;
    const double digits_a = std::frexp(a, &exponent_a), digits_b = std::frexp(b, &exponent_b);
    ASSERT_EQ(digits_a, digits_b) << key << ": " << a << " and " << b;
    if (a == 0.0) return;
    const int shift = exponent_b - exponent_a;
    const auto of = known().find(key);
    EXPECT_EQ(shift, of == known().end() ? shift : of->second.shift(units_)) << key;
  }

 private:
  Units units_;
};

class UnitsTest : public testing_cli::Command, public testing::WithParamInterface<unsigned> {
 protected:
  static Units some(unsigned seed, bool even) {
    std::mt19937 random(1000 + seed);
    const auto power = [&] { return std::uniform_int_distribution<int>(-12, 12)(random); };
    // Norms in L2 have half a power of the length.
    return {even ? 2 * power() : power(), power(), power()};
  }

  /// The scene of that number as plain.toml, and in other units as other.toml.
  void write(const RandomText& scene, const Units& units, const std::string& suffix = ".toml") const {
    std::ofstream(directory_ / ("plain" + suffix)) << RandomText(scene).in({});
    std::ofstream(directory_ / ("other" + suffix)) << RandomText(scene).in(units);
  }

  /// Both, by the command, in which {} stands for plain and other: both end alike, what they say is the same.
  void expect_same(unsigned seed, const std::string& command, bool even, bool plain = false) {
    const Units units = some(seed, even);
    const RandomText scene(seed, plain);
    write(scene, units);
    std::array<testing_cli::Ended, 2> ended;
    for (const bool other : {false, true})
      ended[other] =
          viscobar(std::regex_replace(command, std::regex("\\{\\}"), std::string(other ? "other" : "plain")));
    SCOPED_TRACE(fmt::format("seed {}: {}, length 2^{}, mass 2^{}, time 2^{}\n{}", seed, command, units.length,
                             units.mass, units.time, RandomText(scene).in({})));
    ASSERT_EQ(ended[0].code, ended[1].code) << ended[0].error << ended[1].error;
    EXPECT_EQ(ended[0].out.empty(), ended[1].out.empty());
    if (ended[0].code == 2) {
      ++refused_;
      EXPECT_EQ(words(std::regex_replace(ended[0].error, std::regex("plain"), "other")), words(ended[1].error));
    }
    if (ended[0].out.empty()) return;
    Same(units).expect(of_the_scene(ended[0].json()), of_the_scene(ended[1].json()), "");
  }

  int refused_ = 0;
};

TEST_P(UnitsTest, ARunAndACheckHaveTheSameDigitsInAllUnits) {
  for (unsigned seed = 20 * GetParam(); seed < 20 * GetParam() + 20; ++seed) {
    expect_same(seed, "run {}.toml --json -o out", false);
    expect_same(seed, "check {}.toml --json", false);
    if (HasFatalFailure() || HasFailure()) return;
  }
  EXPECT_LE(refused_, 10);  // most scenes run
}

TEST_P(UnitsTest, AStudyHasTheSameDigitsInAllUnits) {
  for (unsigned seed = 20 * GetParam(); seed < 20 * GetParam() + 20; seed += 10) {
    expect_same(seed, "compare {}.toml --json -o out --methods cvode,fully_discrete", true);
    expect_same(seed, "limit {}.toml --json -o out --budget 0", true);
    // None is left out for its time.
    expect_same(seed, "precision {}.toml --json -o out --tolerance 1e-3:1e-4 --halvings 1 --repeat 3 --seconds 1e6",
                true);
    if (HasFatalFailure() || HasFailure()) return;
  }
}

TEST_P(UnitsTest, ARunThatAsksForAnErrorHasTheSameDigitsInAllUnits) {
  const char* of[] = {"displacement", "end_traces", "contact_times", "impulse", "peak_reaction"};
  const std::string goal = of[GetParam() % 5];
  expect_same(20 * GetParam(), "run {}.toml --error '3 %' --set accuracy.of=" + goal + " --json -o out", false, true);
}

TEST_P(UnitsTest, SensitivitiesHaveTheSameDigitsInAllUnits) {
  for (unsigned seed = 20 * GetParam(); seed < 20 * GetParam() + 20; seed += 4) {
    expect_same(seed, "run {}.toml --json -o out --set method.name=rigid --sensitivity bar.modulus,bar.density", false,
                true);
    if (HasFatalFailure() || HasFailure()) return;
  }
  EXPECT_EQ(refused_, 0);
}

TEST_P(UnitsTest, AFitHasTheSameDigitsInAllUnits) {
  const unsigned seed = 20 * GetParam() + 3;
  write(RandomText(seed, true, 1.05), some(seed, false), "-true.toml");
  for (const std::string name : {"plain", "other"})
    viscobar("run " + name + "-true.toml -q -o " + name + "-true --set mesh.elements=20");
  expect_same(seed,
              "fit {}.toml --data {}-true/ends.csv --parameters bar.modulus --json -o fitted --runs 12 "
              "--set method.name=rigid --set mesh.elements=20",
              false, true);
  EXPECT_EQ(refused_, 0);
}

// By the units that the columns of the table name.
TEST_P(UnitsTest, ARowOfASweepHasTheSameDigitsInAllUnits) {
  const std::map<std::string_view, Dimension> of_unit = {{"1", none},          {"time", a_time},
                                                         {"length", a_length}, {"energy", an_energy},
                                                         {"force", a_stress},  {"force x time", {-1, 1, -1}}};
  const Units units{5, -3, 8};
  for (unsigned seed = 20 * GetParam(); seed < 20 * GetParam() + 20; ++seed) {
    RandomText scene(seed);
    const auto plain = run_case(scene.in({}), {0, {}}), other = run_case(scene.in(units), {0, {}});
    ASSERT_TRUE(plain && other);
    ASSERT_EQ(plain->completed, other->completed) << plain->error << other->error;
    for (std::size_t k = 0; k < quantities; ++k) {
      const QuantityColumn& column = quantity_columns()[k];
      const double a = plain->values[k], b = other->values[k];
      if (std::isnan(a) && std::isnan(b)) continue;
      EXPECT_EQ(std::ldexp(a, of_unit.at(column.unit).shift(units)), b) << column.name << "\n" << scene.in({});
    }
    if (HasFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(TwoHundredScenes, UnitsTest, testing::Range(0u, 10u));

}  // namespace
}  // namespace viscobar
