// Derivatives through stops with a law of their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "laws/scene.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar::laws {
namespace {

constexpr std::array with_derivatives = {"cvode", "ida", "arkode"};

std::string asked(const std::string& keys) { return fmt::format("[sensitivity]\nof = [{}]\n", keys); }

double slope(const std::function<double(double)>& f, double x) {
  const double h = 1e-3 * x;  // the error is h^4 / 30 of a fifth derivative
  return (8.0 * (f(x + h) - f(x - h)) - f(x + 2 * h) + f(x - 2 * h)) / (12.0 * h);
}

// T = 2 acos(zeta) / (q w), and what is left of the speed exp(-zeta w T), as functions of k and of c.
TEST(LawSensitivity, OfALoneMassIsThatOfItsClosedForm) {
  const double k = 3.0, c = 0.7;
  const auto time = [](double stiffness, double damping) {
    const double w = std::sqrt(stiffness), zeta = damping / (2.0 * w);
    return 2.0 * std::acos(zeta) / (std::sqrt(1.0 - zeta * zeta) * w);
  };
  const auto speed = [&](double stiffness, double damping) {
    return std::exp(-0.5 * damping * time(stiffness, damping));
  };
  for (const char* method : with_derivatives) {
    SCOPED_TRACE(method);
    const Recording recording =
        record(parse_scene(lone_mass("mass = 1\n" + contact("spring_damper", k, c), 1.0, time(k, c) + 0.5, method) +
                               asked("\"left.contact.stiffness\", \"left.contact.damping\""),
                           "")
                   .run);
    ASSERT_EQ(recording.events.size(), 2u);
    const auto& of = recording.events[1].sensitivities;
    // The tolerance of derivatives is that of the motion, relative to their own size, times its promised multiple.
    EXPECT_NEAR(of.at(0).time, slope([&](double x) { return time(x, c); }, k), 1e-7);
    EXPECT_NEAR(of.at(1).time, slope([&](double x) { return time(k, x); }, c), 1e-7);
    EXPECT_NEAR(of.at(0).velocity, slope([&](double x) { return speed(x, c); }, k), 1e-7);
    EXPECT_NEAR(of.at(1).velocity, slope([&](double x) { return speed(k, x); }, c), 1e-7);
  }
}

std::string bar(const std::string& stop, double viscosity, double gap, const char* method) {
  return fmt::format(
      "[bar]\nlength = 1\nviscosity = {:.17g}\n[left]\nkind = \"obstacle\"\ngap = {:.17g}\n{}[initial]\nvelocity = "
      "-1\n[time]\nend = 3\n[mesh]\nelements = 8\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-10\n[output]\nevery = "
      "0.5\n",
      viscosity, gap, stop, method);
}

// By the motion itself, at values of the parameters on either side.
TEST(LawSensitivity, IsThatOfDifferencesForEachLaw) {
  const std::array<std::string, 4> keys = {"bar.viscosity", "left.gap", "left.contact.stiffness",
                                           "left.contact.damping"};
  for (const char* law : {"spring_damper", "hertz", "hunt_crossley"})
    for (const char* method : with_derivatives) {
      const std::array<double, 4> at = {0.1, 0.2, 20.0, 0.4};
      const auto recorded = [&](std::array<double, 4> p, const std::string& more) {
        return record(parse_scene(bar(contact(law, p[2], p[3]), p[0], p[1], method) + more, "").run);
      };
      for (std::size_t p = 0; p < (std::string(law) == "hertz" ? 3 : 4); ++p) {
        SCOPED_TRACE(fmt::format("{} {} {}", law, method, keys[p]));
        const Recording run = recorded(at, asked("\"" + keys[p] + "\""));
        const double step = 1e-3 * at[p];
        std::array<Recording, 2> beside;
        for (const int side : {0, 1}) {
          auto moved = at;
          moved[p] += side == 0 ? -step : step;
          beside[static_cast<std::size_t>(side)] = recorded(moved, "");
        }
        const auto difference = [&](auto&& of) { return (of(beside[1]) - of(beside[0])) / (2.0 * step); };
        ASSERT_EQ(run.events.size(), beside[0].events.size());
        ASSERT_EQ(run.events.size(), beside[1].events.size());
        // A second difference of relative step 1e-3 is off by some 1e-6 of what a third derivative makes.
        const auto close = [](double a, double b) { return 2e-5 * (1.0 + std::max(std::abs(a), std::abs(b))); };
        for (std::size_t k = 0; k < run.events.size(); ++k) {
          const double by_differences = difference([&](const Recording& r) { return r.events[k].time; });
          EXPECT_NEAR(run.events[k].sensitivities[0].time, by_differences, close(by_differences, 0.0));
          const double of_velocity = difference([&](const Recording& r) { return r.events[k].velocity; });
          EXPECT_NEAR(run.events[k].sensitivities[0].velocity, of_velocity, close(of_velocity, 0.0));
        }
        for (std::size_t i = 0; i < run.u.size(); ++i) {
          const double of_u = difference([&](const Recording& r) { return r.u[i]; });
          EXPECT_NEAR(run.sensitivities[0].u[i], of_u, close(of_u, 0.0));
          const double of_v = difference([&](const Recording& r) { return r.v[i]; });
          EXPECT_NEAR(run.sensitivities[0].v[i], of_v, close(of_v, 0.0));
        }
        for (std::size_t i = 0; i < run.times.size(); ++i) {
          const double of_r = difference([&](const Recording& r) { return r.reaction_left[i]; });
          EXPECT_NEAR(run.sensitivities[0].reaction_left[i], of_r, close(of_r, 0.0));
        }
        const auto& account = *run.statistics.sensitivity;
        EXPECT_FALSE(account.lost);
        const double of_energy = difference([](const Recording& r) { return r.statistics.energy->final; });
        EXPECT_NEAR(account.energy[0], of_energy, close(of_energy, 0.0));
        const double of_impulse = difference([](const Recording& r) { return r.statistics.account->left.impulse; });
        EXPECT_NEAR(account.impulse_left[0], of_impulse, close(of_impulse, 0.0));
      }
    }
}

// lambda is a function of them.
TEST(LawSensitivity, OfARestitutionAndASpeedIsThatOfDifferences) {
  const auto recorded = [](double e, double V, const std::string& more) {
    const std::string stop = fmt::format(
        "contact = {{ law = \"hunt_crossley\", stiffness = 20, restitution = {:.17g}, speed = {:.17g} }}\n", e, V);
    return record(parse_scene(bar(stop, 0.1, 0.2, "cvode") + more, "").run);
  };
  const Recording run = recorded(0.6, 1.5, asked("\"left.contact.restitution\", \"left.contact.speed\""));
  for (const int p : {0, 1}) {
    SCOPED_TRACE(p == 0 ? "restitution" : "speed");
    const auto of = [&](double by, auto&& value) {
      return value(recorded(0.6 + (p == 0 ? by : 0.0), 1.5 + (p == 1 ? by : 0.0), ""));
    };
    const auto expect = [&](double derivative, auto&& value) {
      // A second difference of step 1e-3, as above.
      EXPECT_NEAR(derivative, (of(1e-3, value) - of(-1e-3, value)) / 2e-3, 2e-5 * (1.0 + std::abs(derivative)));
      EXPECT_GT(std::abs(derivative), 1e-4);
    };
    const auto k = static_cast<std::size_t>(p);
    expect(run.sensitivities[k].u.back(), [](const Recording& r) { return r.u.back(); });
    expect(run.events.at(1).sensitivities[k].time, [](const Recording& r) { return r.events.at(1).time; });
    expect(run.statistics.sensitivity->impulse_left[k],
           [](const Recording& r) { return r.statistics.account->left.impulse; });
  }
  EXPECT_THROW(recorded(0.6, 1.5, asked("\"left.contact.damping\"")), SceneError);
}

// c = 0 is where a stop begins to open before its surface: the time has a derivative to one side alone.
TEST(LawSensitivity, OfADampingThatIsZeroIsRefused) {
  const auto text = [](const char* law) {
    return bar(contact(law, 20.0), 0.1, 0.2, "cvode") + asked("\"left.contact.damping\"");
  };
  EXPECT_THROW(parse_scene(text("spring_damper"), ""), SceneError);
  EXPECT_NO_THROW(parse_scene(text("hunt_crossley"), ""));
}

// By the exact trace of an end, from 1.2 times each number. Measured: off by 5e-8 of them at most.
TEST(LawFit, GivesBackTheNumbersOfStopsMassesAndSides) {
  const auto given_back = [](const std::string& law, const std::vector<std::string>& keys,
                             const std::vector<double>& truth) {
    SCOPED_TRACE(law + " " + keys.front());
    const std::string scene = bar("mass = 0.3\n" + contact(law, 20.0, 0.4), 0.1, 0.2, "arkode") +
                              "[right]\nkind = \"free\"\nmass = 0.2\n[side]\nstiffness = 2.0\ndrag = 0.3\n";
    FitStudy study;
    study.model = [&](std::span<const double> values) {
      std::vector<std::string> set = {"output.every=0.05",
                                      fmt::format("sensitivity.of=[\"{}\"]", fmt::join(keys, "\",\""))};
      for (std::size_t k = 0; k < keys.size(); ++k) set.push_back(fmt::format("{}={:.17g}", keys[k], values[k]));
      return parse_scene(scene, "", set).run;
    };
    const Recording made = record(study.model(truth));
    study.times = made.times;
    MeasuredTrace trace;
    trace.deviation = 0.01;
    for (std::size_t k = 0; k < made.times.size(); ++k) trace.values.push_back(made.displacement(k).front());
    study.traces.push_back(trace);
    for (std::size_t k = 0; k < keys.size(); ++k) study.parameters.push_back({keys[k], 1.2 * truth[k], 1e-6, 1e6});
    const FitResult found = fit(study);
    EXPECT_TRUE(found.converged) << found.reason;
    for (std::size_t k = 0; k < keys.size(); ++k)
      EXPECT_NEAR(found.parameters[k].estimate, truth[k], 1e-6 * truth[k]) << keys[k];
  };
  const std::vector<std::string> numbers = {"left.contact.stiffness", "left.contact.damping"};
  given_back("spring_damper", numbers, {20.0, 0.4});
  given_back("hunt_crossley", numbers, {20.0, 0.4});
  given_back("hertz", {"left.contact.stiffness"}, {20.0});
  given_back("hertz", {"left.mass", "right.mass"}, {0.3, 0.2});
  given_back("spring_damper", {"side.stiffness", "side.drag"}, {2.0, 0.3});
}

}  // namespace
}  // namespace viscobar::laws
