#include "case/alarm.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "report/scene_check.hpp"
#include "support/paper_throw.hpp"
#include "support/scene_text.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

Case throw_by(MethodName method) {
  Case run = paper_throw(0.01);
  run.method = method;
  run.restitution = 0.0;
  return run;
}

struct Sounded {
  Case run;
  BarSystem system;
  Statistics statistics;
  explicit Sounded(MethodName method) : run(throw_by(method)), system(resolve(run).system()) {
    Observers observers;
    observers.energy = true;
    statistics = simulate(resolve(run), system, observers);
  }
  std::vector<Alarm> operator()() const { return alarms(resolve(run), system, statistics); }
};

TEST(Alarm, IsSilentOnSoundRuns) {
  for (const MethodName method :
       {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint, MethodName::exponential})
    EXPECT_TRUE(Sounded(method)().empty()) << name(method);
}

constexpr const char* all_methods[] = {"cvode",
                                       "ida",
                                       "arkode",
                                       "odeint",
                                       "rigid",
                                       "exponential",
                                       "characteristics",
                                       "fully_discrete",
                                       "finite_difference"};

Statistics run_of(const Case& run) {
  Observers observers;
  observers.energy = true;
  return simulate(resolve(run), observers);
}

// Energies of such data are infinite, whichever of the data it is.
TEST(Alarm, DataThatAreTooLargeForSquaresEndInAMessageByEveryMethod) {
  const std::vector<std::pair<std::string, std::string>> huge[] = {
      {{"load.density", "\"1e300*t\""}},
      {{"initial.velocity", "-1e200"}},
      {{"initial.velocity", "0"}, {"initial.displacement", "\"1e180*x^2\""}},
      {{"left.force", "\"1e200*sin(t)\""}}};
  for (const char* method : all_methods)
    for (auto changes : huge) {
      changes.emplace_back("method.name", std::string("\"") + method + "\"");
      if (method == std::string("characteristics")) changes.emplace_back("bar.viscosity", "0.0");
      const std::string text = falling_bar_with(changes);
      try {
        EXPECT_TRUE(overflow(run_of(parse_scene(text, "scene").run))) << text;
      } catch (const IntegrationError& error) {
        EXPECT_NE(std::string(error.what()).find("too large"), std::string::npos) << error.what() << text;
      }
    }
}

// Squares of less than 1e-154 are 0, so energies, balances and error norms say nothing then; denormal data have no end.
TEST(Alarm, DataThatAreTooSmallForSquaresEndInAMessageByEveryMethod) {
  const std::vector<std::pair<std::string, std::string>> tiny[] = {
      {{"initial.velocity", "-1e-310"}},
      {{"initial.velocity", "0"}, {"initial.displacement", "\"1e-310*x\""}},
      {{"initial.velocity", "\"exp(-711*(1+x))\""}},
      {{"initial.velocity", "0"}, {"left.force", "\"1e-300*sin(t)\""}},
      {{"initial.velocity", "0"}, {"load.density", "\"1e-300*sin(t)\""}},
      {{"initial.velocity", "-1.9e-211"}, {"left.gap", "1.9e-212"}}};
  for (const char* method : all_methods)
    for (auto changes : tiny) {
      changes.emplace_back("method.name", std::string("\"") + method + "\"");
      if (method == std::string("characteristics")) changes.emplace_back("bar.viscosity", "0.0");
      const std::string text = falling_bar_with(changes);
      try {
        run_of(parse_scene(text, "scene").run);
        ADD_FAILURE() << text;
      } catch (const IntegrationError& error) {
        EXPECT_NE(std::string(error.what()).find("too small for the squares of double precision"), std::string::npos)
            << error.what() << text;
      }
      EXPECT_THROW(check_scene(parse_scene(text, "scene")), std::invalid_argument) << text;
    }
  // The waves of a bar without viscosity are followed to choose its method; here they are 0 where the bar is thrown.
  for (const char* shape : {"\"exp(-711*(1+x))\"", "\"5e-324*sin(3*x)\""}) {
    const std::string text = std::string(
                                 "bar.length = 1.0\nleft.kind = \"obstacle\"\nleft.gap = 0.1\n"
                                 "initial.velocity = -1\ntime.end = 1.0\nmesh.elements = 20\n"
                                 "initial.displacement = ") +
                             shape;
    EXPECT_EQ(run_of(parse_scene(text, "scene").run).events, 1u) << text;
  }
}

// All data times 2^k: the equations are linear, contact included, and a power of two changes no digit.
TEST(Alarm, DataOfOtherSizesMoveTheBarInProportion) {
  for (const char* method : all_methods) {
    const auto lowest = [&](double scale) {
      const std::string text =
          falling_bar_with({{"initial.velocity", fmt::format("{}", -scale)},
                            {"left.gap", fmt::format("{}", 0.1 * scale)},
                            {"bar.viscosity", method == std::string("characteristics") ? "0.0" : "0.1"},
                            {"method.name", fmt::format("\"{}\"", method)}});
      double last = 0.0;
      Observers observers;
      observers.snapshot = [&](const Snapshot& now) { last = now.u.back() / scale; };
      const Case run = parse_scene(text, "scene").run;
      simulate(resolve(run), observers);
      return last;
    };
    const double at_one = lowest(1.0);
    for (const int power : {-300, 300}) EXPECT_NEAR(lowest(std::ldexp(1.0, power)), at_one, 1e-9) << method << power;
  }
}

// The tolerances allow a share of the largest energy on the way, although none is left at the end.
TEST(Alarm, IsSilentWhereABarComesToRest) {
  const std::string steel = "[bar]\nlength = 1.0\nmodulus = 2.1e11\ndensity = 7800\n[mesh]\nelements = 10\n";
  for (const std::string& scene :
       {std::string("[bar]\nlength = 1.0\n[load]\ndensity = \"cos(2*pi*t)\"\n[time]\nend = 1.0\n"),
        "[mesh]\nelements = 20\n" +
            std::string("[bar]\nlength = 1.0\n[load]\ndensity = \"cos(2*pi*t)\"\n[time]\nend = 1.0\n"),
        std::string("[bar]\nlength = 1.0\nviscosity = 0.1\n[load]\nprofile = \"1+x\"\n"
                    "history = \"sin(4*pi*t)\"\n[time]\nend = 2.0\n"),
        steel + "[load]\nprofile = 1.0\nhistory = \"t<0.01 ? 7800 : -7800\"\n[time]\nend = 0.02\n"})
    for (const char* method : all_methods) {
      if (method == std::string("characteristics") && scene.find("viscosity") != std::string::npos) continue;
      const SceneFile file = parse_scene(scene + "[method]\nname = \"" + method + "\"\n", "scene");
      const Statistics statistics = run_of(file.run);
      for (const Alarm& alarm : alarms(resolve(file.run), resolve(file.run).system(), statistics))
        ADD_FAILURE() << method << ": " << alarm.what << "\n" << scene;
    }
}

// A bar that gets the speed 0.1 and flies a hundred of its lengths: E = 39. Its own account must not multiply by E/h
// what rounding makes of u, which is 10; the tolerances promise 2e-4 E, and all of it is taken in the first 0.1.
// Nothing moves the bar, but roundings of 0.03.
TEST(Alarm, IsSilentOnABarAtRestAwayFromZero) {
  for (const char* method : {"exponential", "cvode", "ida", "arkode", "odeint", "rigid", "fully_discrete"}) {
    const Case run =
        parse_scene(
            fmt::format("[bar]\nlength = 2\ndensity = 0.5\nmodulus = 2\n[left]\nkind = \"obstacle\"\ngap = "
                        "0.05\n[initial]\ndisplacement = -0.03\n[time]\nend = 0.5\n[mesh]\nelements = 20\nmass = "
                        "\"lumped\"\n[contact]\nepsilon = 1e-4\n[method]\nname = \"{}\"\n",
                        method),
            "")
            .run;
    const auto setup = resolve(run);
    const BarSystem system = setup.system();
    Observers observers;
    observers.energy = true;
    Statistics statistics = simulate(setup, system, observers);
    EXPECT_TRUE(alarms(setup, system, statistics).empty()) << method;
    statistics.energy->work += 1e-63;
    EXPECT_TRUE(alarms(setup, system, statistics).empty()) << method;
    statistics.energy->work += 1e-20;
    EXPECT_FALSE(alarms(setup, system, statistics).empty()) << method;
  }
}

TEST(Alarm, KnowsTheEnergyOfABarThatTravelsFar) {
  for (const char* method : {"cvode", "ida", "arkode", "rigid", "exponential", "fully_discrete"}) {
    const Case run =
        parse_scene(std::string("[bar]\nlength = 1.0\nmodulus = 2.1e11\ndensity = 7800\n[mesh]\nelements = 10\n"
                                "[load]\nprofile = 1.0\nhistory = \"t<0.1 ? 7800 : 0\"\n[time]\nend = 100.0\n"
                                "[output]\nevery = 20\n[method]\nstep = 0.001\nname = \"") +
                        method + "\"\n",
                    "scene")
            .run;
    const Statistics statistics = run_of(run);
    EXPECT_NEAR(statistics.energy->final, 39.0, run.method == MethodName::fully_discrete ? 1.0 : 39.0 * 2e-4) << method;
    EXPECT_LE(std::abs(statistics.energy->balance_error()), 39.0 * 1e-9) << method;
  }
}

// 1e5 lengths away roundings of u are strains, r 1e5 / h, beside an energy of 2.5e-5.
TEST(Alarm, CountsTheRoundingsOfFarDisplacements) {
  for (const char* method : {"exponential", "fully_discrete", "finite_difference", "rigid", "cvode"}) {
    const Case run =
        parse_scene(std::string("[bar]\nlength = 1.0\n[initial]\ndisplacement = 1e5\nvelocity = \"0.01*sin(6*x)\"\n"
                                "[mesh]\nelements = 20\n[time]\nend = 20\n[method]\nname = \"") +
                        method + "\"\n",
                    "scene")
            .run;
    for (const Alarm& alarm : alarms(resolve(run), resolve(run).system(), run_of(run)))
      ADD_FAILURE() << method << ": " << alarm.what;
  }
}

TEST(Alarm, NamesABalanceOfASchemeThatIsOff) {
  const Case run = parse_scene(
                       "[bar]\nlength = 1.0\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = 0.1\n"
                       "[initial]\nvelocity = -1.0\n[time]\nend = 1.0\n[method]\nname = \"fully_discrete\"\n",
                       "scene")
                       .run;
  Statistics statistics = run_of(run);
  const BarSystem system = resolve(run).system();
  EXPECT_TRUE(alarms(resolve(run), system, statistics).empty());
  statistics.energy->dissipated *= 0.9;
  ASSERT_EQ(alarms(resolve(run), system, statistics).size(), 1u);
  EXPECT_TRUE(alarms(resolve(run), system, statistics)[0].ruinous);
}

TEST(Alarm, NamesABalanceThatIsOff) {
  Sounded run(MethodName::arkode);
  run.statistics.energy->final += 1e-3 * run.statistics.energy->initial;
  ASSERT_EQ(run().size(), 1u);
  EXPECT_FALSE(run()[0].ruinous);
  EXPECT_NE(run()[0].what.find("balance"), std::string::npos);
  run.statistics.energy->final = 1737.0;  // beside 0.25, as from an interpolation of the spring's oscillation
  EXPECT_TRUE(run()[0].ruinous);
}

// A loss that is wrong neither counts as the energy that its error is small beside, nor do loose tolerances excuse it.
TEST(Alarm, MeasuresALossByWhatTheBarHas) {
  Sounded run(MethodName::arkode);
  EnergyAccount& energy = *run.statistics.energy;
  run.run.tolerance.relative = 1e-2;
  energy.dissipated = energy.largest = 3.5 * energy.initial;
  ASSERT_EQ(run().size(), 1u);
  EXPECT_TRUE(run()[0].ruinous);
  energy.dissipated = energy.largest = 1.1 * energy.initial - energy.final;
  ASSERT_EQ(run().size(), 1u);
  EXPECT_FALSE(run()[0].ruinous);
}

TEST(Alarm, NamesEnergyFromNowhere) {
  Sounded run(MethodName::arkode);
  EnergyAccount& energy = *run.statistics.energy;
  energy.final += 2.0 * energy.dissipated;
  energy.dissipated = -energy.dissipated;
  ASSERT_EQ(run().size(), 1u);
  EXPECT_NE(run()[0].what.find("without a cause"), std::string::npos);
}

TEST(Alarm, NamesAPenetrationThatNoEnergyExplains) {
  Sounded run(MethodName::arkode);
  run.statistics.max_penetration = 1.0;
  ASSERT_EQ(run().size(), 1u);
  EXPECT_TRUE(run()[0].ruinous);
}

TEST(Alarm, NamesAnOpeningWithAPullLeft) {
  Sounded run(MethodName::arkode);
  EXPECT_LT(run.statistics.late_opening.ratio, 1.0);
  run.statistics.late_opening = {20.0, 1.5};
  ASSERT_EQ(run().size(), 1u);
  EXPECT_NE(run()[0].what.find("1.5"), std::string::npos);
}

// Work and loss are integrals of the velocity of a node without mass; that of an explicit method at its bound of
// stability is an error times the bound: 0.0115 of work for 0.0100 at this tolerance.
TEST(Alarm, EnergiesOfAPushedEndWithoutMassAreThoseOfItsMotionByOdeint) {
  const auto energy = [](const char* method) {
    return *record(
                parse_scene(fmt::format("[bar]\nlength = 1.0\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = "
                                        "0.05\nforce = -0.2\n[right]\nkind = \"free\"\n[time]\nend = 3.0\n[mesh]\n"
                                        "elements = 10\nmass = \"redistributed\"\n[contact]\nepsilon = 1e-3\n[method]\n"
                                        "name = \"{}\"\nrelative_tolerance = 1e-3\n",
                                        method),
                            "")
                    .run)
                .statistics.energy;
  };
  const auto right = energy("exponential"), odeint = energy("odeint");
  EXPECT_NEAR(odeint.work, right.work, 0.01 * right.work);
  EXPECT_NEAR(odeint.dissipated, right.dissipated, 0.01 * right.work);
}

}  // namespace
}  // namespace viscobar
