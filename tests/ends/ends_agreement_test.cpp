// Random bars whose ends are given everything at once, by independent methods: they agree, their energy balances, and
// a run that goes on from a checkpoint is the same.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

class RandomEnds {
 public:
  explicit RandomEnds(unsigned seed) : random_(seed) {
    viscosity_ = coin() ? uniform(0.02, 0.2) : 0.0;
    text_ = fmt::format("[bar]\nlength = {}\ndensity = {}\nmodulus = {}\nviscosity = {}\n", uniform(0.7, 1.5),
                        uniform(0.5, 2.0), uniform(0.5, 2.0), viscosity_);
    for (const char* side : {"left", "right"}) add_end(side);
    text_ +=
        fmt::format("[initial]\ndisplacement = \"{}*sin({}*x+{})^2\"\nvelocity = \"{}+{}*x\"\n", uniform(0.0, 0.05),
                    uniform(1.0, 5.0), uniform(0.0, 3.0), uniform(-0.5, 0.3), uniform(-0.5, 0.5));
    if (coin())
      text_ += fmt::format("[load]\nprofile = \"cos({}*x)\"\nhistory = \"sin({}*t)\"\n", uniform(0, 3), uniform(1, 5));
    masses_ = !mounted_contact_ ? std::vector<std::string>{"consistent", "lumped", "fourth_order", "redistributed"}
                                : std::vector<std::string>{"consistent", "lumped", "fourth_order"};
  }

  std::string by(const std::string& method, double epsilon, const std::string& more = "", double end = 2.0) const {
    return fmt::format(
        "{}[time]\nend = {}\n[mesh]\nelements = 8\nmass = \"{}\"\n[contact]\nepsilon = {}\n{}[method]\nname = \"{}\"\n"
        "relative_tolerance = 1e-9\nstep = 1e-4\n[output]\nevery = 0.1\n",
        text_, end, masses_[seed_of_mass_ % masses_.size()], epsilon, more, method);
  }
  bool contact() const { return contact_; }
  bool algebraic() const {
    return viscosity_ == 0.0 && contact_ && masses_[seed_of_mass_ % masses_.size()] == "redistributed";
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  bool coin() { return uniform(0.0, 1.0) < 0.5; }

  void add_end(const char* side) {
    const double kind = uniform(0.0, 1.0);
    const auto wave = [&](double size) {
      std::string text = fmt::format("{}*(1-cos({}*t))+{}*sin({}*t)^2", uniform(-size, size), uniform(1.0, 6.0),
                                     uniform(-size, size), uniform(1.0, 4.0));
      if (coin()) text += fmt::format("+{}*max(0,t-{})", uniform(-size, size), uniform(0.3, 1.5));  // a kink
      return text;
    };
    if (kind < 0.25) {
      text_ += fmt::format("[{}]\nkind = \"fixed\"\n", side);
      if (coin()) text_ += fmt::format("motion = \"{}\"\n", wave(0.2));
      return;
    }
    const bool obstacle = kind < 0.8;
    contact_ |= obstacle;
    text_ += fmt::format("[{}]\nkind = \"{}\"\n", side, obstacle ? "obstacle" : "free");
    if (obstacle) {
      const double gap = uniform(0.06, 0.2);
      text_ += coin() ? fmt::format("gap = {}\n", gap) : fmt::format("gap = \"{}+{}\"\n", gap, wave(0.1));
      if (coin()) text_ += "side = \"above\"\n";
    }
    if (coin()) text_ += fmt::format("force = \"{}*sin({}*t)\"\n", uniform(-1.0, 1.0), uniform(1.0, 5.0));
    if (coin()) text_ += fmt::format("stiffness = {}\n", uniform(0.1, 3.0)), mounted_contact_ |= obstacle;
    if (coin()) text_ += fmt::format("dashpot = {}\n", uniform(0.1, 2.0)), mounted_contact_ |= obstacle;
  }

  std::mt19937 random_;
  std::string text_;
  double viscosity_;
  bool contact_ = false, mounted_contact_ = false;
  std::vector<std::string> masses_;
  std::size_t seed_of_mass_ = random_() % 12;
};

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

double largest_of(const std::vector<double>& a) {
  double most = 0.0;
  for (const double x : a) most = std::max(most, std::abs(x));
  return most;
}

constexpr unsigned scenes = 40;

// The promise of the adaptive methods, a hundred times the tolerance of the displacement, in the frame of what moves,
// whose displacements and velocities may be a few times those of the bar.
TEST(EndInputs, AdaptiveMethodsKeepTheirPromiseAgainstTheExponential) {
  for (unsigned seed = 1; seed <= scenes; ++seed) {
    const RandomEnds random(seed);
    const std::string text = random.by("exponential", 1e-3);
    SCOPED_TRACE(text);
    const Recording exact = record(parse_scene(text, "").run);
    for (const std::string method : {"cvode", "ida", "arkode", "odeint"}) {
      if (seed % 4 != std::map<std::string, unsigned>{{"cvode", 0}, {"ida", 1}, {"arkode", 2}, {"odeint", 3}}[method] &&
          method != "cvode")
        continue;
      if (random.algebraic() && (method == "cvode" || method == "odeint")) continue;
      const Recording one = record(parse_scene(random.by(method, 1e-3), "").run);
      const double u = largest_of(exact.u) + 0.5;
      EXPECT_LT(difference(one.u, exact.u), 100 * 1e-9 * u) << method;
      ASSERT_EQ(one.events.size(), exact.events.size()) << method;
      const EndAccount &a = one.statistics.account->left, &b = exact.statistics.account->left;
      const EndAccount &p = one.statistics.account->right, &q = exact.statistics.account->right;
      for (const auto& [x, y] : {std::pair{&a, &b}, {&p, &q}}) {
        EXPECT_NEAR(x->lowest, y->lowest, 1e-6);
        EXPECT_NEAR(x->highest, y->highest, 1e-6);
        EXPECT_NEAR(x->displacement, y->displacement, 1e-6);
        EXPECT_NEAR(x->impulse, y->impulse, 1e-5);
        EXPECT_NEAR(x->peak_reaction, y->peak_reaction, 1e-3 * (1.0 + y->peak_reaction));
      }
      const EnergyAccount &e = *one.statistics.energy, &f = *exact.statistics.energy;
      EXPECT_NEAR(e.initial, f.initial, 1e-12);
      EXPECT_NEAR(e.final, f.final, 1e-5);
      EXPECT_NEAR(e.work, f.work, 1e-5);
      EXPECT_NEAR(e.dissipated, f.dissipated, 1e-5);
      EXPECT_NEAR(e.balance_error(), 0.0, 1e-6) << method;
      EXPECT_NEAR(f.balance_error(), 0.0, 1e-9);
    }
  }
}

// With a restitution of 0 the penalty and the scheme have one limit, reached like sqrt(epsilon) and dt.
TEST(EndInputs, TheSchemeAndRigidAndTheStiffPenaltyHaveOneLimit) {
  for (unsigned seed = 1; seed <= scenes; ++seed) {
    const RandomEnds random(seed);
    const std::string text = random.by("fully_discrete", 1e-7, "restitution = 0\n");
    SCOPED_TRACE(text);
    const Recording scheme = record(parse_scene(text, "").run);
    const Recording penalty = record(parse_scene(random.by("exponential", 1e-7, "restitution = 0\n"), "").run);
    const Recording rigid = record(parse_scene(random.by("rigid", 1e-7, "restitution = 0\n"), "").run);
    // Impacts of an end node on a mesh of eight elements make jumps of the velocity; how they are resolved in time
    // decides on that much of the displacement.
    EXPECT_LT(difference(scheme.u, rigid.u), 2e-3);
    EXPECT_LT(difference(penalty.u, rigid.u), 2e-3);
    EXPECT_NEAR(scheme.statistics.energy->balance_error(), 0.0, 1e-9);
    EXPECT_NEAR(rigid.statistics.energy->balance_error(), 0.0, 1e-5);
    if (!random.contact()) {
      EXPECT_LT(difference(scheme.u, penalty.u), 1e-4);  // dt of the first step
    }
  }
}

TEST(EndInputs, ARunFromACheckpointIsTheSameBitForBit) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const RandomEnds random(seed);
    for (const std::string method : {"cvode", "ida", "arkode", "odeint", "rigid", "exponential", "fully_discrete"}) {
      if (random.algebraic() && (method == "cvode" || method == "odeint")) continue;
      const std::string text = random.by(method, 1e-3, "restitution = 0.5\n");
      SCOPED_TRACE(text);
      const Case run = parse_scene(text, "").run;
      const BarSystem system = make_system(run);
      std::vector<double> first, second;
      std::optional<Checkpoint> kept;
      const auto observers = [&](std::vector<double>& into) {
        Observers all;
        all.energy = all.account = true;
        all.snapshot = [&into](const Snapshot& at) {
          into.insert(into.end(), at.u.begin(), at.u.end());
          into.insert(into.end(), at.v.begin(), at.v.end());
          into.push_back(at.reaction_left);
          into.push_back(at.reaction_right);
        };
        all.checkpoints = Checkpoints{.every = 0.7, .asked = {}, .take = [&](const Checkpoint& at) {
                                        if (!kept) kept = at, second = first;
                                        return RunControl::go_on;
                                      }};
        return all;
      };
      const Statistics whole = simulate(run, system, observers(first));
      ASSERT_TRUE(kept);
      const BarSystem again = make_system(run);
      const Statistics rest = simulate(run, again, *kept, observers(second));
      EXPECT_EQ(first, second);
      EXPECT_EQ(whole.energy->work, rest.energy->work);
      EXPECT_EQ(whole.energy->final, rest.energy->final);
      EXPECT_EQ(whole.energy->dissipated, rest.energy->dissipated);
      EXPECT_EQ(whole.account->left.impulse, rest.account->left.impulse);
      EXPECT_EQ(whole.account->right.lowest, rest.account->right.lowest);
    }
  }
}

}  // namespace
}  // namespace viscobar
