// Derivatives of chains by keys of their bars and joints against differences of runs, and what is made of them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "dynamics/gauge.hpp"
#include "viscobar/case/case.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {
namespace {

using Settings = std::vector<std::string>;

// All numbers of a run that have a derivative, or their derivatives.
struct Told {
  std::vector<double> values;
  std::size_t changes = 0;
  std::optional<double> lost;
};

Told told_by(const Case& run, bool derivatives) {
  Told told;
  std::vector<double>& all = told.values;
  Observers observers;
  if (derivatives) observers.directions = run.directions;
  observers.account = observers.energy = true;
  const auto add = [&](const auto& at) {
    all.insert(all.end(), at.u.begin(), at.u.end());
    all.insert(all.end(), at.v.begin(), at.v.end());
    all.push_back(at.reaction_left), all.push_back(at.reaction_right);
    all.insert(all.end(), at.joint_forces.begin(), at.joint_forces.end());
  };
  observers.snapshot = [&](const Snapshot& at) { derivatives ? add(at.sensitivities[0]) : add(at); };
  std::vector<double> times;
  observers.event = [&](const Event& event) {
    ++told.changes;
    times.push_back(derivatives ? event.sensitivities[0].time : event.time);
    times.push_back(derivatives ? event.sensitivities[0].velocity : event.velocity);
  };
  const Statistics done = simulate(resolve(run), observers);
  all.insert(all.end(), times.begin(), times.end());
  if (derivatives) {
    const SensitivityAccount& account = *done.sensitivity;
    told.lost = account.lost;
    all.insert(all.end(), {account.impulse_left[0], account.impulse_right[0], account.energy[0]});
  } else {
    all.insert(all.end(), {done.account->left.impulse, done.account->right.impulse, done.energy->final});
  }
  return told;
}

// Derivatives by differences of fourth order: with steps of d the value's size they are wrong by some d^4 of it, and by
// what a run is wrong by over d.
void expect_derivatives(const std::string& text, const std::string& key, double value, Settings settings) {
  const Case start = parse_scene(text, "", settings).run;
  const auto at = [&](double now, bool derivatives) {
    Settings all = settings;
    all.push_back(fmt::format("{}={:.17g}", key, now));
    if (derivatives) all.push_back(fmt::format("sensitivity.of=[\"{}\"]", key));
    Case run = parse_scene(text, "", all).run;
    run.elements = start.elements, run.bar_meshes = start.bar_meshes;  // bars share them by their numbers
    return told_by(run, derivatives);
  };
  constexpr double tolerance = 1e-10, share = 2e-3;
  const double d = share * std::abs(value);
  const Told own = at(value, true);
  const std::array told = {at(value - 2.0 * d, false), at(value - d, false), at(value + d, false),
                           at(value + 2.0 * d, false)};
  ASSERT_FALSE(own.lost) << key;
  for (const Told& one : told) ASSERT_EQ(one.values.size(), own.values.size()) << key << ": other contacts";
  double largest = 0.0, worst = 0.0;
  std::vector<double> by_differences;
  for (std::size_t k = 0; k < own.values.size(); ++k) {
    by_differences.push_back((8.0 * (told[2].values[k] - told[1].values[k]) - told[3].values[k] + told[0].values[k]) /
                             (12.0 * d));
    largest = std::max(largest, std::abs(by_differences.back()));
    worst = std::max(worst, std::abs(by_differences.back() - own.values[k]));
  }
  // 100 tolerances of the derivative, of a run over d, and the fifth derivative of waves, (T / transit)^5 at most.
  EXPECT_GT(largest, 0.0) << key;
  EXPECT_LT(worst / largest, 100.0 * tolerance * (1.0 + 1.0 / share) + 1e3 * std::pow(share, 4)) << settings[0] << key;
}

// A ram on a cushion; a stepped pair with a bonded joint, which two unlike bars meet that come with other speeds.
const std::string unlike =
    "[[bar]]\nmass = 0.5\nvelocity = 1.0\n[[bar]]\nlength = 0.6\nviscosity = 0.08\nvelocity = \"1.0+0.2*x\"\n"
    "[[bar]]\nlength = 0.5\ndensity = 1.7\nmodulus = 2.5\nviscosity = 0.12\nsection = 1.3\n"
    "[[bar]]\nlength = 0.8\ndensity = 0.8\nmodulus = 1.4\nviscosity = 0.1\nvelocity = -0.4\n"
    "[[joint]]\nkind = \"spring\"\nstiffness = 4.0\ndamping = 0.3\n[[joint]]\nkind = \"contact\"\ngap = 0.08\n"
    "[[joint]]\nkind = \"bonded\"\n[initial]\nvelocity = \"-0.3*x\"\n[right]\nkind = \"obstacle\"\ngap = 0.3\nside = "
    "\"above\"\n[time]\nend = 1.6\n[output]\nevery = 0.2\n[mesh]\nelements = 36\n[contact]\nepsilon = 1e-2\n"
    "restitution = 0.3\n[method]\nrelative_tolerance = 1e-10\n";

const std::map<std::string, double> keys = {
    {"bar.1.mass", 0.5},    {"bar.2.density", 1.0},   {"bar.2.modulus", 1.0},   {"bar.2.viscosity", 0.08},
    {"bar.3.density", 1.7}, {"bar.3.modulus", 2.5},   {"bar.4.viscosity", 0.1}, {"bar.4.density", 0.8},
    {"bar.2.length", 0.6},  {"bar.3.length", 0.5},    {"joint.1.stiffness", 4}, {"joint.1.damping", 0.3},
    {"joint.2.gap", 0.08},  {"contact.epsilon", 1e-2}};

TEST(ChainSensitivities, AreThoseOfDifferencesThroughSoftContacts) {
  for (const char* method : {"cvode", "arkode", "ida"})
    for (const auto& [key, value] : keys)
      if (method[0] == 'c' || key == "bar.3.modulus" || key == "joint.2.gap")
        expect_derivatives(unlike, key, value, {fmt::format("method.name={}", method), "time.end=2", "right.gap=0.02"});
}

TEST(ChainSensitivities, AreThoseOfDifferencesThroughImpacts) {
  for (const auto& [key, value] : keys)
    if (key != "contact.epsilon")
      expect_derivatives(unlike, key, value,
                         {"method.name=rigid", "contact.restitution=0", "time.end=3", "right.gap=0.02"});
  for (const char* key : {"bar.2.density", "bar.3.density", "joint.2.gap", "contact.restitution"})
    expect_derivatives(unlike, key, std::string(key) == "contact.restitution" ? 0.4 : keys.at(key),
                       {"method.name=rigid", "contact.restitution=0.4", "time.end=0.066"});
}

TEST(ChainSensitivities, OfParametersOfFormulas) {
  const std::string text = unlike + "[parameters]\nspeed = 1.0\n";
  for (const char* method : {"cvode", "rigid"})
    expect_derivatives(text, "parameters.speed", 1.0,
                       {fmt::format("method.name={}", method), "bar.1.velocity=speed", "bar.2.velocity=speed*(1+0.2*x)",
                        "initial.velocity=-0.3*speed*x", "contact.restitution=0"});
}

TEST(ChainSensitivities, RefuseWhatHasNoneAndSayWhy) {
  const auto complaint = [](const std::string& key, Settings settings) {
    settings.push_back("sensitivity.of=[\"" + key + "\"]");
    try {
      (void)parse_scene(unlike, "", settings);
    } catch (const SceneError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(complaint("bar.3.section", {"bar.3.section=1+x"}).find("it varies along the bar"), std::string::npos);
  EXPECT_NE(complaint("bar.modulus", {}).find("bar.1.length"), std::string::npos);
  EXPECT_NE(complaint("joint.3.gap", {}).find("no sensitivity"), std::string::npos);
  EXPECT_NE(complaint("bar.2.modulus", {"method.name=exponential"}).find("rigid"), std::string::npos);
}

// The Hopkinson test of examples/scenes, whose gauges are the data.
struct Gauged {
  std::vector<double> times;
  std::array<std::vector<double>, 2> strain;
};

Gauged gauged(Case run, double every) {
  run.output_every = every;
  const Setup setup = resolve(run);
  const std::vector<Gauge> gauges = make_gauges(run.gauges, setup.mesh, run.scene);
  Gauged found;
  Observers observers;
  observers.snapshot = [&](const Snapshot& at) {
    found.times.push_back(at.time);
    for (std::size_t k = 0; k < 2; ++k) found.strain[k].push_back(gauges[k](at.u, at.v).strain);
  };
  (void)simulate(setup, observers);
  return found;
}

const std::string hopkinson = std::string(VISCOBAR_SOURCE_DIR) + "/examples/scenes/hopkinson.toml";

// Without noise the fit ends where the data came from, to what its own steps leave: a thousandth of a deviation of 1 %.
TEST(Hopkinson, AFitGivesModulusAndViscosityOfTheSpecimenBack) {
  const Settings coarse = {"mesh.elements=200", "time.end=3.5"};
  const Gauged data = gauged(read_scene(hopkinson, coarse).run, 0.02);
  FitStudy study;
  study.times = data.times;
  for (std::size_t k = 0; k < 2; ++k)
    study.traces.push_back({TraceColumn::strain_at, data.strain[k], 0.005, true, k == 0 ? 1.5 : 2.6});
  study.parameters = {{"bar.3.modulus", 0.4, 0.01, 10.0}, {"bar.3.viscosity", 0.001, 0.0, 1.0}};
  const Case start = read_scene(hopkinson, coarse).run;
  study.model = [&](std::span<const double> values) {
    Settings settings = coarse;
    settings.push_back(fmt::format("bar.3.modulus={:.17g}", values[0]));
    settings.push_back(fmt::format("bar.3.viscosity={:.17g}", values[1]));
    settings.push_back("sensitivity.of=[\"bar.3.modulus\", \"bar.3.viscosity\"]");
    Case run = read_scene(hopkinson, settings).run;
    run.elements = start.elements, run.bar_meshes = start.bar_meshes;
    return run;
  };
  const FitResult result = fit(study);
  EXPECT_TRUE(result.converged) << result.reason;
  EXPECT_NEAR(result.parameters[0].estimate, 0.2, 1e-3 * 0.2);
  EXPECT_NEAR(result.parameters[1].estimate, 0.004, 1e-2 * 0.004);
}

// A wave loses its edge on the way x to a gauge, by sigma^2 = eta x / (rho c^3), so that the strain is wrong by sigma^2
// N' / (2 l); N' is E times the rate where the specimen gives way. Its faces' mean stress is wrong by rho l^2 / 12 of
// the second derivative, over its time (1 + 2 eta / (l Z)) l Z / (2 E) of loading; and stress of the bars is not E e
// alone. The pulse lasts 1, to which the specimen is l / c_s long.
TEST(Hopkinson, ThreeWavesTellModulusAndViscosityOfTheSpecimen) {
  for (const double viscosity : {1e-3, 1e-4}) {
    Settings settings = {"mesh.elements=800", "bar.3.elements=16", "time.end=4.5"};
    for (const int bar : {1, 2, 4}) settings.push_back(fmt::format("bar.{}.viscosity={}", bar, viscosity));
    const Gauged data = gauged(read_scene(hopkinson, settings).run, 0.005);
    const std::filesystem::path file = std::filesystem::temp_directory_path() / "viscobar-hopkinson-gauges.csv";
    std::ofstream stream(file);
    stream << "t,strain@1.5,strain@2.6\n";
    for (std::size_t k = 0; k < data.times.size(); ++k)
      stream << fmt::format("{},{},{}\n", data.times[k], data.strain[0][k], data.strain[1][k]);
    stream.close();
    const std::string out = file.string() + ".txt";
    if (std::system("python3 --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "no python3";
    ASSERT_EQ(std::system(fmt::format("python3 '{}/examples/python/hopkinson.py' '{}' >'{}'", VISCOBAR_SOURCE_DIR,
                                      file.string(), out)
                              .c_str()),
              0);
    std::ifstream answer(out);
    std::string word;
    double modulus = 0.0, damping = 0.0;
    char comma = ' ';
    answer >> word >> modulus >> comma >> word >> damping;
    constexpr double l = 0.02, E = 0.2, eta = 0.004, loading = (1.0 + 2.0 * eta / l) * l / (2.0 * E);
    const double blur = viscosity * 1.0 * E * E / (2.0 * l), inertia = l * l / 12.0 / loading, own = viscosity * E;
    EXPECT_NEAR(damping, eta, 1.5 * blur + inertia + own) << viscosity;
    EXPECT_NEAR(modulus, E, E * l / std::sqrt(E) / 1.0) << viscosity;
    std::filesystem::remove(file);
    std::filesystem::remove(out);
  }
}

// Each strikes with the velocities that the one before it leaves.
TEST(ChainSensitivities, OfTwoContactsThatCloseAtTheStartFollowBothImpacts) {
  const std::string text =
      "[[bar]]\nlength = 1.0\nviscosity = 0.1\nelements = 12\nvelocity = 1.0\n[[bar]]\nlength = 1.0\nviscosity = 0.1\n"
      "elements = 12\nvelocity = 0.0\n[[bar]]\nlength = 1.0\nviscosity = 0.1\nelements = 12\nvelocity = -0.5\n[[joint]]\nkind "
      "= \"contact\"\n[[joint]]\nkind = \"contact\"\n[time]\nend = 1.0\n[output]\nevery = 0.1\n[method]\nname = "
      "\"rigid\"\nrelative_tolerance = 1e-11\n";
  for (const char* key : {"bar.2.density", "bar.2.length", "bar.1.length"})
    expect_derivatives(text, key, 1.0, {"time.end=1"});
}

// A jump of the load opens it where the jump is, whatever the bar.
TEST(ChainSensitivities, OfAContactThatAJumpOfTheLoadOpensHaveNoTimeOfItsOwn) {
  const std::string text =
      "[bar]\nlength = 1.0\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = 0.1\nforce = \"t<0.25 ? -1 : 2\"\n[initial]\n"
      "velocity = -1.0\n[time]\nend = 1.0\n[mesh]\nelements = 20\n[output]\nevery = 0.1\n[method]\nname = \"rigid\"\n"
      "relative_tolerance = 1e-11\n";
  expect_derivatives(text, "bar.modulus", 1.0, {"time.end=1"});
  expect_derivatives(text, "left.gap", 0.1, {"time.end=1"});
}

// A wall that moves from the start on, before a body that flies freely into another: by its mass m2 the meeting at gap
// / V does not move, nor does V, and v = m2 V / (m2 + m3) has the derivative m3 V / (m2 + m3)^2.
TEST(ChainSensitivity, AnEndThatMovesFromTheStartOnIsNoPartOfIt) {
  Case run =
      parse_scene(
          "[[bar]]\nlength = 1.0\nviscosity = 0.1\nelements = 3\n[[bar]]\nmass = 1.0\nvelocity = 1.0\n[[bar]]\nmass = "
          "0.5\n[[joint]]\nkind = \"contact\"\ngap = 2.0\n[[joint]]\nkind = \"contact\"\ngap = 0.1\n[left]\nkind = "
          "\"fixed\"\nmotion = \"0.1*sin(3*t)\"\n[time]\nend = 1.0\n[mesh]\nmass = \"lumped\"\n[method]\nname = "
          "\"rigid\"\nrelative_tolerance = 1e-10\n",
          "")
          .run;
  run.directions = {direction(run, "bar.2.mass")};
  std::vector<double> meeting, last;
  Observers observers;
  observers.directions = run.directions;
  observers.event = [&](const Event& event) { meeting.push_back(event.sensitivities[0].time); };
  observers.snapshot = [&](const Snapshot& at) { last = {at.sensitivities[0].u.back(), at.sensitivities[0].v.back()}; };
  simulate(resolve(run), observers);
  ASSERT_EQ(meeting.size(), 1U);
  EXPECT_NEAR(meeting[0], 0.0, 1e-12);
  const double of_speed = 0.5 / (1.5 * 1.5);
  EXPECT_NEAR(last[1], of_speed, 1e-9);
  EXPECT_NEAR(last[0], 0.9 * of_speed, 1e-9);
}

// The velocities of the start fit no free end with a dashpot, and high modes are put at their equilibrium, which
// springs along the bar have a share in.
TEST(ChainSensitivities, OfWhatHighModesAtAJumpMakeOfASide) {
  for (const char* key : {"side.stiffness", "bar.modulus", "bar.length", "parameters.c"})
    expect_derivatives(
        "[bar]\nlength = 1.0\nviscosity = 0.05\n[left]\nkind = \"free\"\ndashpot = 0.3\n[right]\nkind = "
        "\"free\"\ndashpot = 0.4\n[initial]\nvelocity = -1.0\n[time]\nend = 0.5\n[output]\nevery = "
        "0.05\n[parameters]\nc = 5.0\n[mesh]\nelements = 8\nmass = \"fourth_order\"\n[method]\nname = "
        "\"rigid\"\nrelative_tolerance = 1e-11\nabsolute_tolerance = 1e-11\n",
        key, key[0] == 'b' ? 1.0 : 5.0, {fmt::format("side.stiffness={}", key[0] == 'p' ? "c*(1 + 0.2*x)" : "5.0")});
}

// They have one by the momentum of both; the derivative by c is 0 on either side of the joint.
TEST(ChainSensitivities, OfVelocitiesThatABondMakesOne) {
  for (const char* mass : {"lumped", "consistent", "fourth_order"})
    for (const auto& [key, value] :
         std::map<std::string, double>{{"parameters.c", -0.4}, {"bar.1.mass", 0.5}, {"bar.2.density", 1.1}})
      expect_derivatives(
          "[[bar]]\nmass = 0.5\nvelocity = 0.5\n[[bar]]\nlength = 0.9\ndensity = 1.1\nviscosity = 0.1\nelements = "
          "5\nvelocity = \"c*x\"\n[parameters]\nc = -0.4\n[time]\nend = 1.0\n[output]\nevery = 0.125\n[method]\nname = "
          "\"rigid\"\nrelative_tolerance = 1e-11\nabsolute_tolerance = 1e-11\n",
          key, value, {fmt::format("mesh.mass={}", mass)});
}

// Data by moments, or by values at nodes, are so in the scenes beside, too. The body ends the chain, and so does the
// cube, which changes no derivative.
TEST(ChainSensitivities, OfTheLengthOfABarBeforeABody) {
  const std::string text =
      "[[bar]]\nmass = 0.5\nvelocity = 0.4\n[[bar]]\nlength = 0.8\nviscosity = 0.1\nelements = 8\nvelocity = "
      "\"-0.1-0.3*cos(3*x)\"\n[[bar]]\nmass = 0.4\n[[joint]]\nkind = \"spring\"\nstiffness = 2.0\n[[joint]]\n"
      "kind = \"spring\"\nstiffness = 2.0\n[time]\nend = 1.0\n[output]\nevery = 0.125\n[method]\nname = \"rigid\"\n"
      "relative_tolerance = 1e-11\nabsolute_tolerance = 1e-11\n";
  for (const char* mass : {"lumped", "consistent", "fourth_order"})
    for (const char* held :
         {"side.stiffness=2-x^2{}", "side.drag=2-x^2{}", "load.density=2-x^2{}", "load.profile=2-x^2{}"}) {
      const auto settings = [&](const char* more) {
        Settings all{fmt::format("mesh.mass={}", mass), fmt::format(fmt::runtime(held), more)};
        if (all[1].starts_with("load.profile")) all.emplace_back("load.history=1+t");
        return all;
      };
      const char* kink_inside = "+1e-12*max(0,x-0.4)";
      expect_derivatives(text, "bar.2.length", 0.8, settings(""));
      expect_derivatives(text, "bar.2.length", 0.8, settings(kink_inside));
      const auto derivatives = [&](const char* more) {
        Settings all = settings(more);
        all.push_back("sensitivity.of=[\"bar.2.length\"]");
        return told_by(parse_scene(text, "", all).run, true).values;
      };
      const std::vector<double> inside = derivatives(kink_inside), at_end = derivatives("+max(0,x-0.8)^3");
      ASSERT_EQ(inside.size(), at_end.size());
      for (std::size_t k = 0; k < inside.size(); ++k)
        ASSERT_TRUE(std::abs(at_end[k] - inside[k]) < 1e-8 || (std::isnan(at_end[k]) && std::isnan(inside[k])))
            << mass << held << at_end[k] << " " << inside[k];  // NaN: the impulse of an end without an obstacle
    }
}

// The end that stops at 0.1 leaves the other one with a pull, which opens at that time by it.
TEST(ChainSensitivities, OfAContactThatAnotherOnesImpactTearsOff) {
  for (const char* key : {"left.gap", "parameters.c"})
    expect_derivatives(
        "[bar]\nlength = 0.6144\ndensity = 1.1456\nmodulus = 0.9333\nviscosity = 0.3339\n[left]\nkind = "
        "\"obstacle\"\ngap = 0.042\nside = \"above\"\nmass = 0.3256\n[right]\nkind = \"obstacle\"\ngap = "
        "\"0.1147*sin(2.66*t)\"\nside = \"above\"\ndashpot = 0.0702\nmass = 0.1728\nforce = -0.2462\n[initial]\nvelocity = "
        "\"c*(1 + 0.3*x)\"\n[load]\ndensity = \"0.412*sin(1.705*x + 2*t)\"\n[parameters]\nc = 0.415\n[time]\nend = "
        "1.5\n[output]\nevery = 0.13\n[mesh]\nelements = 3\nmass = \"fourth_order\"\n[method]\nname = "
        "\"rigid\"\nrelative_tolerance = 1e-11\nabsolute_tolerance = 1e-11\n",
        key, key[0] == 'l' ? 0.042 : 0.415, {"method.name=rigid"});
}

// A profile enters by its moments; so do derivatives by a number of its history.
TEST(ChainSensitivities, OfTheHistoryOfALoad) {
  for (const char* bar : {"[bar]\nlength = 1.0\nviscosity = 0.1\n",
                          "[[bar]]\nlength = 1.0\nviscosity = 0.1\n[[bar]]\nmass = "
                          "0.5\n"})
    for (const char* mass : {"consistent", "fourth_order"})
      expect_derivatives(
          std::string(bar) +
              "[load]\nprofile = \"sin(4*x)\"\nhistory = \"cos(c*t)\"\n[parameters]\nc = 2.0\n[time]\nend = "
              "1.5\n[output]\nevery = 0.25\n[mesh]\nelements = 5\n[method]\nname = "
              "\"rigid\"\nrelative_tolerance = 1e-11\nabsolute_tolerance = 1e-11\n",
          "parameters.c", 2.0, {fmt::format("mesh.mass={}", mass)});
}

// From nothing the derivative by a gap begins with steps of one rounding of the time.
TEST(ChainSensitivity, OfAGapPassesItsContactAtAnyTolerance) {
  for (const char* tolerance : {"1e-8", "3e-9", "1e-9", "3e-10", "1e-11"})
    for (const char* epsilon : {"1e-2", "1e-3", "1e-4", "1e-6"}) {
      Case run = parse_scene(
                     "[[bar]]\nlength = 1.0\nviscosity = 0.1\nvelocity = 1.0\nelements = 8\n[[bar]]\nlength = "
                     "1.0\nviscosity = 0.1\nelements = 8\n[[joint]]\nkind = \"contact\"\ngap = 0.9\n[time]\nend = "
                     "1.5\n[method]\nname = \"ida\"\n",
                     "",
                     Settings{fmt::format("contact.epsilon={}", epsilon),
                              fmt::format("method.relative_tolerance={}", tolerance)})
                     .run;
      run.directions = {direction(run, "joint.1.gap")};
      Observers observers;
      observers.directions = run.directions;
      observers.account = true;
      EXPECT_TRUE(simulate(resolve(run), observers).completed) << tolerance << " " << epsilon;
    }
}

// A body pressed on a bar bounces until it rests, and derivatives end; another that strikes the bar opens that contact.
TEST(ChainSensitivity, EndsWhereItFirstHasNone) {
  Case run =
      parse_scene(
          "[[bar]]\nmass = 1.0\nvelocity = 0.2\n[[bar]]\nlength = 1.0\nviscosity = 1.0\nelements = 1\n[[bar]]\nmass "
          "= 1.0\nvelocity = -1.0\n[[joint]]\nkind = \"contact\"\ngap = 0.01\n[[joint]]\nkind = \"contact\"\ngap = "
          "1.0\n[left]\nkind = \"free\"\nforce = 1.0\n[time]\nend = 1.5\n[mesh]\nmass = "
          "\"consistent\"\n[contact]\nrestitution = 0.5\n[method]\nname = \"rigid\"\n[output]\nevery = 0.05\n",
          "")
          .run;
  run.directions = {direction(run, "joint.1.gap")};
  double told_until = 0.0;
  Observers observers;
  observers.directions = run.directions;
  observers.snapshot = [&](const Snapshot& at) {
    if (!std::isnan(at.sensitivities[0].u[0])) told_until = at.time;
  };
  const Statistics done = simulate(resolve(run), observers);
  ASSERT_TRUE(done.sensitivity->lost);
  EXPECT_GE(*done.sensitivity->lost, told_until);
  EXPECT_LT(*done.sensitivity->lost, told_until + 0.05);
}

// On each mass the velocities of the start come by their moments, those of the frame by its nodes.
TEST(ChainSensitivities, OfBarsWhoseEndMovesFromTheStartOn) {
  const std::string text =
      "[[bar]]\nlength = 0.8\nviscosity = 0.1\nvelocity = \"-0.5+c*x\"\nelements = 3\n[[bar]]\nlength = 1.2\ndensity = "
      "1.7\nmodulus = 1.5\nviscosity = 0.08\nsection = \"1+0.5*x\"\nvelocity = 0.3\nelements = 4\n[left]\nkind = "
      "\"fixed\"\nmotion = \"0.2*sin(2*t)\"\n[right]\nkind = \"fixed\"\nmotion = \"c*sin(3*t)\"\n[parameters]\nc = "
      "0.1\n[time]\nend = 1.0\n[output]\nevery = 0.125\n[method]\nname = \"rigid\"\nrelative_tolerance = "
      "1e-11\nabsolute_tolerance = 1e-11\n";
  for (const char* joint : {"joint.1.kind=bonded", "joint.1.kind=contact"})
    for (const char* mass : {"lumped", "consistent", "fourth_order"})
      for (const auto& [key, value] : std::map<std::string, double>{
               {"bar.1.density", 1.0}, {"bar.2.density", 1.7}, {"bar.1.length", 0.8}, {"parameters.c", 0.1}})
        expect_derivatives(text + "[[joint]]\n", key, value, {joint, fmt::format("mesh.mass={}", mass)});
}

TEST(ChainSensitivities, OfBarsThatBeginOnAnObstacleThatMoves) {
  const std::string text =
      "[[bar]]\nlength = 0.8\nviscosity = 0.1\nvelocity = \"-0.5+c*x\"\nelements = 3\n[[bar]]\nlength = 1.2\ndensity = "
      "1.7\nmodulus = 1.5\nviscosity = 0.08\nvelocity = -0.2\nelements = 4\n[left]\nkind = \"obstacle\"\ngap = "
      "\"-c*sin(2*t)\"\n[parameters]\nc = 0.1\n[time]\nend = 1.0\n[output]\nevery = 0.125\n[contact]\nepsilon = "
      "1e-2\n[method]\nrelative_tolerance = 1e-11\nabsolute_tolerance = 1e-11\n";
  for (const char* method : {"rigid", "arkode"})
    for (const auto& [key, value] :
         std::map<std::string, double>{{"bar.1.density", 1.0}, {"bar.2.density", 1.7}, {"parameters.c", 0.1}})
      expect_derivatives(text, key, value, {fmt::format("method.name={}", method)});
}

// A bar, one or two bodies beyond it, a wall: the impulse of the wall is told by its law, or by the rows of all that is
// held together with the outer body, which change as the contact between them does.
TEST(ChainSensitivities, OfTheImpulseOnABodyThatABarMeets) {
  const std::string body = "[[bar]]\nmass = 0.3\nvelocity = 0.2\n",
                    contact = "[[joint]]\nkind = \"contact\"\ngap = 0.02\n";
  const std::string bar =
      "[[bar]]\nlength = 1.0\nviscosity = 0.05\nelements = 8\nvelocity = 0.6\nsection = \"1+0.3*x\"\n";
  const std::string ends =
      "[right]\nkind = \"obstacle\"\nside = \"above\"\ngap = 0.03\nstiffness = 0.4\ndashpot = "
      "0.1\n[side]\nstiffness = 0.5\ndrag = 0.2\n[time]\nend = 1.5\n[method]\n"
      "relative_tolerance = 1e-10\n";
  const std::string near = bar + body + contact + ends, far = bar + body + body + contact + contact + ends;
  const std::vector<std::pair<const std::string*, Settings>> cases = {
      {&near, {"method.name=rigid", "contact.restitution=0"}},
      {&far, {"method.name=rigid", "contact.restitution=0", "bar.3.velocity=0.1"}},
      {&near, {"method.name=rigid", "contact.restitution=0.6", "time.end=0.17"}},
      {&near, {"method.name=cvode", "contact.epsilon=1e-2", "contact.restitution=0.5"}},
      {&near, {"method.name=arkode", "contact.epsilon=1e-2", "right.gap=\"0.03-0.01*sin(2*t)\""}},
      {&far,
       {"method.name=ida", "right.contact={ law = \"hunt_crossley\", stiffness = 30.0, damping = 0.4 }",
        "contact.epsilon=1e-2"}}};
  for (const auto& [text, settings] : cases)
    for (const auto& [key, value] : {std::pair{"bar.2.mass", 0.3}, {"bar.1.modulus", 1.0}, {"bar.1.density", 1.0}})
      expect_derivatives(*text, key, value, settings);
}

// Checkpoints beyond where derivatives have ended, at a second impact of the same time.
TEST(ChainSensitivity, ARunGoesOnBeyondItsDerivatives) {
  Case run = parse_scene(
                 "[[bar]]\nmass = 1.0\nvelocity = 1.289\n[[bar]]\nmass = 1.0\nvelocity = 0.579\n[[bar]]\nlength = 1.0\n"
                 "viscosity = 0.02\nelements = 1\nvelocity = 0.38\n[[joint]]\nkind = \"contact\"\n[[joint]]\nkind = "
                 "\"contact\"\n[time]\nend = 1.0\n[method]\nname = \"rigid\"\n[contact]\nrestitution = 0.5\n",
                 "")
                 .run;
  run.directions = {direction(run, "joint.1.gap")};
  Observers observers;
  observers.directions = run.directions;
  observers.checkpoints = {.every = 0.2, .asked = {}, .take = [](const Checkpoint&) { return RunControl::go_on; }};
  const Statistics done = simulate(resolve(run), observers);
  EXPECT_TRUE(done.completed);
  EXPECT_TRUE(done.sensitivity->lost);
}

}  // namespace
}  // namespace viscobar
