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
  explicit RandomEnds(unsigned seed) : random_(seed), masses_at_ends_(1000 + seed) {
    viscosity_ = coin() ? uniform(0.02, 0.2) : 0.0;
    text_ = fmt::format("[bar]\nlength = {}\ndensity = {}\nmodulus = {}\nviscosity = {}\n", uniform(0.7, 1.5),
                        uniform(0.5, 2.0), uniform(0.5, 2.0), viscosity_);
    for (const char* side : {"left", "right"}) add_end(side);
    text_ +=
        fmt::format("[initial]\ndisplacement = \"{}*sin({}*x+{})^2\"\nvelocity = \"{}+{}*x\"\n", uniform(0.0, 0.05),
                    uniform(1.0, 5.0), uniform(0.0, 3.0), uniform(-0.5, 0.3), uniform(-0.5, 0.5));
    if (coin())
      text_ += fmt::format("[load]\nprofile = \"cos({}*x)\"\nhistory = \"sin({}*t)\"\n", uniform(0, 3), uniform(1, 5));
    masses_ = {"consistent", "lumped", "fourth_order"};
    if (bare_contact_ || !contact_) masses_.emplace_back("redistributed");
  }

  std::string by(const std::string& method, double epsilon, const std::string& more = "", double end = 2.0) const {
    return fmt::format(
        "{}[time]\nend = {}\n[mesh]\nelements = 8\nmass = \"{}\"\n[contact]\nepsilon = {}\n{}[method]\nname = \"{}\"\n"
        "relative_tolerance = 1e-9\nstep = 1e-4\n[output]\nevery = 0.1\n",
        text_, end, masses_[seed_of_mass_ % masses_.size()], epsilon, more, method);
  }
  bool contact() const { return contact_; }
  bool massive_contact() const { return massive_contact_; }
  bool algebraic() const {
    return viscosity_ == 0.0 && bare_contact_ && masses_[seed_of_mass_ % masses_.size()] == "redistributed";
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
    bool mounted = false;
    if (coin()) text_ += fmt::format("stiffness = {}\n", uniform(0.1, 3.0)), mounted = true;
    if (coin()) text_ += fmt::format("dashpot = {}\n", uniform(0.1, 2.0)), mounted = true;
    if (masses_at_ends_() % 2 == 1) {
      text_ += fmt::format("mass = {}\n", std::uniform_real_distribution<double>(0.01, 2.0)(masses_at_ends_));
      mounted = true, massive_contact_ |= obstacle;
    }
    bare_contact_ |= obstacle && !mounted;
  }

  std::mt19937 random_, masses_at_ends_;
  std::string text_;
  double viscosity_;
  bool contact_ = false, bare_contact_ = false, massive_contact_ = false;
  std::vector<std::string> masses_;
  std::size_t seed_of_mass_ = random_() % 12;
};

constexpr unsigned scenes = 40;

/// Error bounds that follow from displacements wrong by a hundred tolerances of the largest one, and velocities by as
/// many of theirs, for rho L, E / h, eta / h, spring and dashpot of an end.
struct Allowed {
  Allowed(const Case& run, const Recording& exact) {
    const Bar& bar = run.scene.bar;
    const double h = run.mesh().spacing(), stiffness = bar.modulus / h, viscous = bar.viscosity / h;
    double mount = 0.0, dashpot = 0.0, mass = 0.0;
    for (const EndInput* end : {&run.scene.left_input, &run.scene.right_input})
      mount = std::max(mount, end->stiffness), dashpot = std::max(dashpot, end->dashpot), mass += end->mass;
    // The promise is one of the frame of what moves, whose displacements and velocities are up to twice those of the
    // bar.
    const double largest = 2.0 * viscobar::largest(exact.u), fastest = 2.0 * viscobar::largest(exact.v);
    u = 100.0 * run.tolerance.relative * largest;
    v = 100.0 * run.tolerance.relative * fastest;
    reaction = u / *run.epsilon;
    // The balance of momentum of the end's row, whose mass is rho h / 2 on all of them but a constant, and its own.
    impulse = (bar.density * h + mass) * v + 2.0 * viscous * u + 2.0 * stiffness * run.end * u +
              (mount * run.end + dashpot) * u;
    // |dE| <= (rho L + m) V dv + E L S (2 du / h) + R du + k U du, S = max |u_x|; R, U of the two ends.
    double strain = 0.0, pressed = 0.0;
    for (std::size_t j = 0; j < exact.u.size(); ++j)
      if (j % run.mesh().nodes() != 0) strain = std::max(strain, std::abs(exact.u[j] - exact.u[j - 1]) / h);
    for (const EndAccount* end : {&exact.statistics.account->left, &exact.statistics.account->right})
      pressed += end->peak_reaction;
    energy = (bar.density * bar.length + mass) * fastest * v + 2.0 * stiffness * bar.length * strain * u + pressed * u +
             2.0 * mount * largest * u;
    // Power: eta L (V / h)^2, V the jump of velocities over an element, and c V^2; twice the first times what is wrong.
    dissipated = run.end * (8.0 * viscous / h * bar.length * fastest * v + 4.0 * dashpot * fastest * v);
  }
  double u, v, reaction, impulse, energy, dissipated;
};

// The promise of the adaptive methods.
TEST(EndInputs, AdaptiveMethodsKeepTheirPromiseAgainstTheExponential) {
  for (unsigned seed = 1; seed <= scenes; ++seed) {
    const RandomEnds random(seed);
    const std::string text = random.by("exponential", 1e-3);
    SCOPED_TRACE(text);
    const Case run = parse_scene(text, "").run;
    const Recording exact = record(run);
    const Allowed allowed(run, exact);
    for (const std::string method : {"cvode", "ida", "arkode", "odeint"}) {
      if (seed % 4 != std::map<std::string, unsigned>{{"cvode", 0}, {"ida", 1}, {"arkode", 2}, {"odeint", 3}}[method] &&
          method != "cvode")
        continue;
      if (random.algebraic() && (method == "cvode" || method == "odeint")) continue;
      const Recording one = record(parse_scene(random.by(method, 1e-3), "").run);
      EXPECT_LE(distance(one.u, exact.u), allowed.u) << method;
      EXPECT_LE(distance(one.v, exact.v), allowed.v) << method;
      ASSERT_EQ(one.events.size(), exact.events.size()) << method;
      const EndAccount &a = one.statistics.account->left, &b = exact.statistics.account->left;
      const EndAccount &p = one.statistics.account->right, &q = exact.statistics.account->right;
      for (const auto& [x, y] : {std::pair{&a, &b}, {&p, &q}}) {
        EXPECT_NEAR(x->lowest, y->lowest, allowed.u);
        EXPECT_NEAR(x->highest, y->highest, allowed.u);
        EXPECT_NEAR(x->displacement, y->displacement, allowed.u);
        EXPECT_NEAR(x->impulse, y->impulse, allowed.impulse);
        EXPECT_NEAR(x->peak_reaction, y->peak_reaction, allowed.reaction);
      }
      const EnergyAccount &e = *one.statistics.energy, &f = *exact.statistics.energy;
      EXPECT_NEAR(e.initial, f.initial, 1e-14 * f.initial);
      EXPECT_NEAR(e.final, f.final, allowed.energy);
      EXPECT_NEAR(e.dissipated, f.dissipated, allowed.energy + allowed.dissipated);
      EXPECT_NEAR(e.work, f.work, 2.0 * allowed.energy + allowed.dissipated);  // by the balance of the other two
      EXPECT_NEAR(e.balance_error(), 0.0, allowed.energy + allowed.dissipated) << method;
      EXPECT_NEAR(f.balance_error(), 0.0, 1e-9);
    }
  }
}

// With a restitution of 0 the penalty and the scheme have one limit. The penalty comes to it like epsilon, by which a
// node that rests gives way, or like its root where a mass is stopped. The scheme comes to it like dt: its start is of
// first order.
TEST(EndInputs, TheSchemeAndRigidAndTheStiffPenaltyHaveOneLimit) {
  std::size_t in_contact = 0;
  for (unsigned seed = 1; seed <= scenes; ++seed) {
    const RandomEnds random(seed);
    const std::string law = "restitution = 0\n";
    SCOPED_TRACE(random.by("fully_discrete", 1e-7, law));
    const auto by = [&](const std::string& method, double epsilon, double step) {
      Case run = parse_scene(random.by(method, epsilon, law), "").run;
      run.step = step;
      return record(run);
    };
    const Recording rigid = by("rigid", 1e-7, 1e-4);
    EXPECT_NEAR(rigid.statistics.energy->balance_error(), 0.0, 1e-5);
    const auto off = [&](const Recording& one) { return distance(one.u, rigid.u); };
    const Recording coarse = by("fully_discrete", 1e-7, 4e-4), fine = by("fully_discrete", 1e-7, 1e-4);
    EXPECT_NEAR(fine.statistics.energy->balance_error(), 0.0, 1e-9);  // an identity
    // Where the part of dt^2 shows at these steps (one scene of 40, power 1.076), it does not at a quarter of them.
    double power = std::log(off(coarse) / off(fine)) / std::log(4.0);
    if (std::abs(power - 1.0) > 0.05)
      power = std::log(off(fine) / off(by("fully_discrete", 1e-7, 2.5e-5))) / std::log(4.0);
    // A mass is stopped anywhere within a step, by which the error changes by up to its half.
    EXPECT_NEAR(power, 1.0, random.massive_contact() ? 0.5 : 0.05);
    if (rigid.events.empty()) continue;
    ++in_contact;
    // One that strikes with V is V (m epsilon)^(1/2) deep before it stops: where it leaves soon, by its root, and where
    // it rests, as deep as its reaction says.
    const double epsilon = random.massive_contact() ? 1e-6 : 1e-5;
    const double soft = off(by("exponential", epsilon, 1e-4)), stiff = off(by("exponential", 0.01 * epsilon, 1e-4));
    const double power_of_epsilon = std::log(soft / stiff) / std::log(100.0);
    EXPECT_LT(power_of_epsilon, 1.15);
    EXPECT_GT(power_of_epsilon, random.massive_contact() ? 0.25 : 0.85);
  }
  EXPECT_GT(in_contact, scenes / 3);
}

TEST(EndInputs, ARunFromACheckpointIsTheSameBitForBit) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const RandomEnds random(seed);
    for (const std::string method : {"cvode", "ida", "arkode", "odeint", "rigid", "exponential", "fully_discrete"}) {
      if (random.algebraic() && (method == "cvode" || method == "odeint")) continue;
      const std::string text = random.by(method, 1e-3, "restitution = 0.5\n");
      SCOPED_TRACE(text);
      const Case run = parse_scene(text, "").run;
      const BarSystem system = resolve(run).system();
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
      const Statistics whole = simulate(resolve(run), system, observers(first));
      ASSERT_TRUE(kept);
      const BarSystem again = resolve(run).system();
      const Statistics rest = simulate(resolve(run), again, *kept, observers(second));
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
