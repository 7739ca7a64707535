// Accuracy on request, against solutions that are known. docs/accuracy-on-request.md has the estimate.
#include "viscobar/studies/accuracy/accuracy.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <thread>

#include "studies/accuracy/quick_estimate.hpp"
#include "studies/accuracy/sample.hpp"
#include "studies/accuracy/space_error.hpp"
#include "studies/run_limits.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar {
namespace {

using accuracy::MeshStep;

constexpr const char* rebound =
    "[bar]\nlength=1\nviscosity=0.1\n[left]\nkind=\"obstacle\"\ngap=0\n[initial]\nvelocity=-1\n[time]\nend=2.5\n";

AccuracyStudy study_of(const std::string& text, const std::vector<std::string>& settings) {
  const SceneFile scene = parse_scene(text, "scene", settings);
  AccuracyStudy study;
  study.scene = scene.run;
  study.request = *scene.accuracy;
  return study;
}

// The sample that a probe takes in the same run.
accuracy::Sample sample_of(const Case& run, const Recording& recording) {
  accuracy::Probe probe(run, recording.times.size());
  for (std::size_t k = 0; k < recording.times.size(); ++k)
    probe.add(Snapshot{recording.times[k], recording.displacement(k), recording.velocity(k)});
  for (const Event& event : recording.events) probe.add(event);
  return probe.take(recording.statistics);
}

double opening_of(const Recording& recording) {
  for (const Event& event : recording.events)
    if (event.change == Change::opening) return event.time;
  return -1.0;
}

// Contact times to ten digits, from the solution in Laplace space.
TEST(AccuracyOnRequest, TheReboundOfAViscousBarHasTheContactTimeToTheErrorAskedFor) {
  for (const auto& [viscosity, exact] : {std::pair{1.0, 1.3692116746}, {0.1, 1.9124710098}, {0.01, 1.9912495450}})
    for (const double error : {1e-3, 1e-5, 1e-8}) {
      const AccuracyResult result =
          solve(study_of(rebound, {fmt::format("bar.viscosity={}", viscosity), fmt::format("accuracy.error={}", error),
                                   "accuracy.of=contact_times"}));
      const double wrong = std::abs(opening_of(record(result.run)) - exact);
      EXPECT_TRUE(result.estimate.kept) << viscosity << " " << error << result.estimate.doubt;
      EXPECT_LE(wrong, error) << viscosity;
      EXPECT_LE(wrong, result.estimate.total + 1e-10) << viscosity << " " << error;
    }
}

// The bar flies as it is, and closes its contact at the time of its gap. Steps of both lengths that end there at the
// same time know it no better than one of them.
TEST(AccuracyOnRequest, AContactTimeOfASchemeIsKnownToAStep) {
  for (const double gap : {0.201, 0.2033, 0.2057, 0.209, 0.2111}) {
    const AccuracyResult result =
        solve(study_of(rebound, {fmt::format("left.gap={}", gap), "time.end=0.6", "method.name=fully_discrete",
                                 "accuracy.error=1e-3", "accuracy.of=contact_times"}));
    const double wrong = std::abs(record(result.run).events.at(0).time - gap);
    EXPECT_TRUE(result.estimate.kept) << gap << result.estimate.doubt;
    EXPECT_LE(wrong, 1e-3) << gap;
    EXPECT_LE(wrong, result.estimate.total) << gap;
  }
}

// Other work on the machine takes no time of a run: only its own counts.
TEST(AccuracyOnRequest, ABoundOfARunIsProcessorTime) {
  Case run = parse_scene(rebound, "scene", {}).run;
  run.elements = 10;
  const auto setup = resolve(run);
  const BarSystem system = setup.system();
  Observers waiting;
  waiting.snapshot = [](const Snapshot& now) {
    if (now.time == 0.0) std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  };
  EXPECT_NO_THROW(simulate_within({{}, 1.0}, setup, system, waiting));
  EXPECT_THROW(simulate_within({{}, 1e-9}, setup, system, {}), TooLong);
}

std::vector<std::size_t> elements_of(const ErrorEstimate& estimate) {
  std::vector<std::size_t> elements;
  for (const ErrorEstimate::Run& run : estimate.runs) elements.push_back(run.elements);
  return elements;
}

// An estimate uses four meshes, each with half the elements of the next or more: none has the 8 of the pilots if the
// finest has more than 64.
TEST(AccuracyOnRequest, RunsOfTheSearchAloneAreToldFromThoseOfTheEstimate) {
  const AccuracyResult result = solve(study_of(rebound, {"accuracy.error=1e-8"}));
  ASSERT_GT(result.run.elements, 64u);
  std::size_t of_estimate = 0;
  for (const ErrorEstimate::Run& run : result.estimate.runs) {
    EXPECT_TRUE(run.elements > 8 || run.search);
    of_estimate += run.search ? 0 : 1;
  }
  EXPECT_GE(of_estimate, 3u);
  EXPECT_LT(of_estimate, result.estimate.runs.size());
  EXPECT_EQ(elements_of(result.estimate).front(), 8u);
}

TEST(AccuracyOnRequest, RunsThatLookForNoPeaksHaveTheSameMotionContactsAndImpulses) {
  for (const char* method : {"rigid", "cvode", "exponential"}) {
    const Case run =
        parse_scene(rebound, "scene", std::vector<std::string>{fmt::format("method.name=\"{}\"", method)}).run;
    const auto sample = [&](bool peaks) { return accuracy::sample_of(run, run.output_times(), {}, peaks); };
    const accuracy::Sample plain = sample(false), whole = sample(true);
    EXPECT_EQ(plain.u, whole.u) << method;
    EXPECT_EQ(plain.impulse, whole.impulse) << method;
    EXPECT_GT(plain.impulse[0], 0.0) << method;
    ASSERT_EQ(plain.events.size(), whole.events.size()) << method;
    for (std::size_t k = 0; k < plain.events.size(); ++k) EXPECT_EQ(plain.events[k].time, whole.events[k].time);
    EXPECT_GT(whole.peak[0], 0.0) << method;
  }
}

TEST(AccuracyOnRequest, ALooseRequestMakesNoRunOnAsManyElementsAsItsSolution) {
  const AccuracyResult result =
      solve(study_of(rebound, {"bar.viscosity=1", "accuracy.error=1e-2", "accuracy.of=displacement"}));
  EXPECT_TRUE(result.estimate.kept);
  EXPECT_EQ(result.run.elements, 16u);
  EXPECT_EQ(elements_of(result.estimate), (std::vector<std::size_t>{4, 8, 8}));
}

TEST(AccuracyOnRequest, AManufacturedContactKeepsTheDisplacementAskedForAtEveryNode) {
  const exact::ManufacturedContact contact;
  const exact::Solution known = exact::solution(contact);
  for (const double error : {1e-3, 1e-6}) {
    AccuracyStudy study;
    study.scene.scene = known.scene;
    study.scene.method = MethodName::rigid;
    study.scene.end =
        1.3;  // the next contact begins at 1.5, by grazing: up to there no mesh knows whether it has begun
    study.scene.output_every = 0.05;
    study.request.error = error;
    const AccuracyResult result = solve(study);
    EXPECT_TRUE(result.estimate.kept) << result.estimate.doubt;
    double wrong = 0.0;
    const Recording recording = record(result.run);
    for (std::size_t k = 0; k < recording.times.size(); ++k)
      for (std::size_t j = 0; j < recording.mesh.nodes(); ++j)
        wrong = std::max(wrong,
                         std::abs(recording.displacement(k)[j] - known.u(recording.mesh.node(j), recording.times[k])));
    EXPECT_LE(wrong, error);
    EXPECT_LE(wrong, 2.0 * result.estimate.total);  // no bound
  }
}

TEST(AccuracyOnRequest, APercentageIsOfTheLargestValue) {
  const AccuracyResult result = solve(study_of(rebound, {"accuracy.error=0.01 %"}));
  EXPECT_DOUBLE_EQ(*result.estimate.requested, 1e-4 * result.estimate.largest);
  EXPECT_TRUE(result.estimate.kept);
}

TEST(AccuracyOnRequest, AMethodThatPenalisesStaysAndItsEpsilonIsChosen) {
  for (const char* method : {"arkode", "cvode"}) {
    const AccuracyResult result = solve(
        study_of(rebound, {"accuracy.error=1e-6", "accuracy.of=contact_times", fmt::format("method.name={}", method)}));
    EXPECT_EQ(name(result.run.method), method);
    EXPECT_TRUE(result.estimate.kept) << result.estimate.doubt;
    EXPECT_GT(result.estimate.penalty, 0.0);
    EXPECT_LE(std::abs(opening_of(record(result.run)) - 1.9124710098), 1e-6);
  }
}

TEST(AccuracyOnRequest, WhatTheSceneFixesIsKeptAndNamedWhereItForbidsTheError) {
  const std::pair<const char*, const char*> fixed[] = {{"mesh.elements=20", "mesh.elements"},
                                                       {"method.relative_tolerance=0.1", "method.relative_tolerance"},
                                                       {"contact.epsilon=1e-3", "contact.epsilon"}};
  for (const auto& [setting, key] : fixed) {
    const AccuracyResult result = solve(study_of(rebound, {"accuracy.error=1e-6", setting}));
    EXPECT_FALSE(result.estimate.kept) << setting;
    EXPECT_NE(result.estimate.doubt.find(key), std::string::npos) << result.estimate.doubt;
    EXPECT_TRUE(record(result.run).statistics.completed);
  }
}

TEST(AccuracyOnRequest, AnUndampedBarIsFollowedByItsWavesAndTellsItsOwnError) {
  const AccuracyResult result = solve(study_of(rebound, {"bar.viscosity=0", "accuracy.error=1e-12"}));
  EXPECT_EQ(result.run.method, MethodName::characteristics);
  EXPECT_TRUE(result.estimate.kept) << result.estimate.doubt;
  EXPECT_NEAR(opening_of(record(result.run)), 2.0, 1e-12);
}

TEST(AccuracyOnRequest, APeakThatHasNoLimitIsRefused) {
  EXPECT_THROW(study_of(rebound, {"accuracy.error=1e-3", "accuracy.of=peak_reaction"}), SceneError);
  const AccuracyResult undamped =
      solve(study_of(rebound, {"bar.viscosity=0", "accuracy.error=1e-9", "accuracy.of=peak_reaction"}));
  EXPECT_TRUE(undamped.estimate.kept) << undamped.estimate.doubt;
  EXPECT_NEAR(undamped.estimate.largest, 1.0, 1e-9);
}

// At a spring the reaction of an elastic bar rises as 1 - exp(-t / epsilon), until the wave from the free end is there.
TEST(AccuracyOnRequest, APeakAtASoftStopIsThatOfItsSpring) {
  for (const char* method : {"cvode", "ida", "odeint"})
    for (const double epsilon : {0.3, 0.1}) {
      const AccuracyResult result = solve(study_of(
          "[bar]\nlength = 1.0\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[initial]\nvelocity = -1.0\n[time]\nend = 3.0\n",
          {"accuracy.error=1e-2", "accuracy.of=peak_reaction", fmt::format("contact.epsilon={}", epsilon),
           fmt::format("method.name={}", method)}));
      EXPECT_TRUE(result.estimate.kept) << method << result.estimate.doubt;
      EXPECT_NEAR(result.estimate.largest, 1.0 - std::exp(-2.0 / epsilon), 1e-2) << method << epsilon;
    }
}

// An undamped bar pressed back to two obstacles: each change of contact magnifies what is wrong.
TEST(AccuracyOnRequest, ASceneThatNoMeshFollowsIsReportedAsSuchAndItsBestSolutionKept) {
  AccuracyStudy study = study_of(
      "[bar]\nlength=1\n[left]\nkind=\"obstacle\"\ngap=0.1\n[right]\nkind=\"obstacle\"\ngap=0.1\n[initial]\n"
      "displacement=\"x*(1-x)\"\nvelocity=\"-x*(1-x)\"\n[load]\ndensity=-1\n[time]\nend=6\n",
      {"contact.epsilon=1e-4", "accuracy.error=1e-4"});
  study.most_elements = 256;
  const AccuracyResult result = solve(study);
  EXPECT_FALSE(result.estimate.kept);
  EXPECT_FALSE(result.estimate.doubt.empty());
  EXPECT_TRUE(record(result.run).statistics.completed);
}

// Order 2 from an impact on: 1e-14 m wants some 400,000 elements. A half of the most that are tried is their least.
TEST(AccuracyOnRequest, OutOfReachTheSolutionIsOnTheFinestMeshThatIsTried) {
  for (const char* gap : {"left.gap=0.001", "left.gap=0.0005", "initial.velocity=-2"}) {
    AccuracyStudy study = study_of(
        "[bar]\nlength=1\ndensity=7800\nmodulus=2.1e11\nviscosity=1e4\n[left]\nkind=\"obstacle\"\ngap=0.001\n"
        "[initial]\nvelocity=-1\n[time]\nend=0.003\n",
        {gap, "accuracy.error=1e-14"});
    study.most_elements = 2000;
    const AccuracyResult result = solve(study);
    EXPECT_FALSE(result.estimate.kept) << gap;
    EXPECT_GT(2 * result.run.elements, study.most_elements) << gap;
    EXPECT_NE(result.estimate.doubt.find(fmt::format("best that was reached, on {} elements", result.run.elements)),
              std::string::npos)
        << result.estimate.doubt;
  }
}

// The runs for the estimate go beside the solution where there is a core for them.
TEST(AccuracyOnRequest, DoesNotDependOnTheNumberOfThreads) {
  for (const char* viscosity : {"bar.viscosity=0.1", "bar.viscosity=0"}) {
    AccuracyStudy study = study_of(rebound, {viscosity, "accuracy.error=1e-6"});
    study.threads = 1;
    const AccuracyResult one = solve(study);
    study.threads = 4;
    const AccuracyResult four = solve(study);
    EXPECT_EQ(one.run.elements, four.run.elements);
    EXPECT_EQ(one.estimate.total, four.estimate.total);
    EXPECT_EQ(one.estimate.runs.size(), four.estimate.runs.size());
  }
}

// Neighbours meet a span obstacle at once: only nodes that stop, on a diagonal mass, tend to one motion. The truth is
// the scheme, which knows no penalty, on a far finer mesh.
TEST(AccuracyOnRequest, APenalisedSpanKeepsTheErrorBesideAFinerRunOfTheScheme) {
  const char* slit =
      "[bar]\nlength=1\nviscosity=0.1\n[span]\ngap=0.1\nside=\"both\"\n[initial]\ndisplacement=\"0.05*cos(pi*x)\"\n"
      "velocity=\"-0.5-0.5*cos(2*pi*x)\"\n[time]\nend=1\n[output]\nevery=0.05\n";
  const double error = 2e-3;
  const AccuracyResult result = solve(study_of(slit, {fmt::format("accuracy.error={}", error), "method.name=arkode"}));
  EXPECT_TRUE(result.estimate.kept) << result.estimate.doubt;
  const Case truth = parse_scene(slit, "truth",
                                 std::vector<std::string>{"method.name=fully_discrete", "mesh.mass=lumped",
                                                          "mesh.elements=512", "method.step=5e-5"})
                         .run;
  const accuracy::Sample fine = accuracy::sample_of(truth, truth.output_times());
  EXPECT_LE(accuracy::difference(sample_of(result.run, record(result.run)), fine, Goal::displacement), error);
}

// Free ends meet it.
constexpr const char* floor_below =
    "[bar]\nlength=1\nviscosity=0.05\n[span]\ngap=0.1\n[initial]\nvelocity=\"-0.5-0.5*cos(2*pi*x)\"\n"
    "[method]\nname=\"fully_discrete\"\nstep=2e-5\n[time]\nend=0.5\n[output]\nevery=0.05\n";

accuracy::Sample on_the_floor(const char* mass, std::size_t elements) {
  const Case run = parse_scene(floor_below, "floor",
                               std::vector<std::string>{fmt::format("mesh.mass={}", mass),
                                                        fmt::format("mesh.elements={}", elements)})
                       .run;
  return accuracy::sample_of(run, run.output_times());
}

TEST(AccuracyOnRequest, ASchemeUnderASpanObstacleKeepsTheErrorOnTheLumpedMass) {
  const double error = 1e-3;
  const AccuracyResult result = solve(study_of(floor_below, {fmt::format("accuracy.error={}", error), "method.step="}));
  EXPECT_EQ(resolve(result.run).mass, Mass::lumped);
  EXPECT_TRUE(result.estimate.kept) << result.estimate.doubt;
  EXPECT_LE(
      accuracy::difference(sample_of(result.run, record(result.run)), on_the_floor("lumped", 512), Goal::displacement),
      error);
}

// Between 32 and 256 elements. Which node touches first jumps with the mesh, and the errors with it.
TEST(AccuracyOnRequest, FreeEndsThatMeetASpanObstacleHaveOrder1OnFourthOrderAnd2OnLumped) {
  const accuracy::Sample fine = on_the_floor("lumped", 512);
  const auto order = [&](const char* mass) {
    const auto error = [&](std::size_t elements) {
      return accuracy::difference(on_the_floor(mass, elements), fine, Goal::displacement);
    };
    return std::log(error(32) / error(256)) / std::log(8.0);
  };
  EXPECT_NEAR(order("fourth_order"), 1.0, 0.35);
  EXPECT_NEAR(order("lumped"), 2.0, 0.35);
}

// The nodes touch from right to left.
constexpr const char* thrown_under_a_span =
    "[bar]\nlength=1\nviscosity=0.003607\n[span]\ngap=0.1075\n[initial]\nvelocity=\"-1.189*(1+0.3*x)\"\n"
    "[time]\nend=3.143\n[mesh]\nelements=20\n[contact]\nrestitution=0.1647\n[output]\nevery=0.05\n";

Case under_a_span(const std::vector<std::string>& settings) {
  return parse_scene(thrown_under_a_span, "scene", settings).run;
}

double left_at_end(const Case& run) { return accuracy::sample_of(run, run.output_times()).u.end()[-1]; }

// Differences between meshes double with each, from 0.004 on: 20 to 1280 elements are 0.2 apart.
TEST(Estimates, OfARestitutionUnderASpanCoverTheRestitution0ThatMeshesOfAViscousBarTendTo) {
  for (const char* impact : {"paoli_schatzman", "moreau"}) {
    const auto law = fmt::format("method.impact={}", impact);
    const double limit = left_at_end(under_a_span({"contact.restitution=0", "mesh.elements=80"}));
    for (const std::size_t elements : {20, 80}) {
      const Case run = under_a_span({law, "method.name=fully_discrete", fmt::format("mesh.elements={}", elements)});
      const accuracy::QuickEstimate found = accuracy::quick_estimate(run, {}, 60.0);
      ASSERT_TRUE(found.estimate) << found.why_not;
      EXPECT_GT(found.estimate->total, 0.9 * std::abs(left_at_end(run) - limit));
      EXPECT_NE(found.estimate->doubt.find("tend to restitution 0"), std::string::npos) << found.estimate->doubt;
      EXPECT_FALSE(found.estimate->order);
    }
  }
  const AccuracyResult asked = solve(study_of(thrown_under_a_span, {"accuracy.error=1e-2", "mesh.elements="}));
  EXPECT_FALSE(asked.estimate.kept);
  EXPECT_NE(asked.estimate.doubt.find("tend to restitution 0"), std::string::npos) << asked.estimate.doubt;
}

// Without restitution, without viscosity, and where all nodes touch at once.
TEST(Estimates, OfASpanThatLosesNoReboundHaveNoDoubt) {
  for (const auto& [setting, most] :
       {std::pair{"contact.restitution=0", 0.03}, {"bar.viscosity=0", 0.2}, {"initial.velocity=-1.189", 1e-3}}) {
    const accuracy::QuickEstimate found = accuracy::quick_estimate(under_a_span({setting}), {}, 60.0);
    ASSERT_TRUE(found.estimate) << found.why_not;
    EXPECT_EQ(found.estimate->doubt, "") << setting;
    EXPECT_LT(found.estimate->total, most) << setting;
  }
}

// A border of contact that runs at V leaves the node before it h / V to be pulled by one that is thrown back: on meshes
// finer than eta / (rho V), here 1/80, it comes slowly, and there is little to throw back.
TEST(RestitutionUnderASpan, IsLostOnFineMeshesOfAViscousBarWhoseNodesTouchOneAfterAnother) {
  const auto end = [](const char* elements, const char* restitution) {
    return left_at_end(under_a_span({"bar.viscosity=0.8537", "span.gap=0.0636", "initial.velocity=-1.298*(1+0.3*x)",
                                     "time.end=0.5", "output.every=0.5", fmt::format("mesh.elements={}", elements),
                                     fmt::format("contact.restitution={}", restitution)}));
  };
  const double flat = left_at_end(under_a_span({"bar.viscosity=0.8537", "span.gap=0.0636", "initial.velocity=-1.298",
                                                "time.end=0.5", "output.every=0.5", "contact.restitution=0.6784"}));
  const double coarse = end("20", "0.6784"), finer = end("80", "0.6784"), fine = end("320", "0.6784"),
               limit = end("80", "0");
  EXPECT_GT(flat - limit, 0.3);
  EXPECT_LT(fine - limit, 0.65 * (finer - limit));
  EXPECT_LT(finer - limit, 0.85 * (coarse - limit));
  EXPECT_GT(fine, limit);
}

// Waves without viscosity on a mesh, beside the waves themselves.
TEST(AccuracyOnRequest, AnUndampedBarOnAMeshKeepsTheErrorBesideItsWaves) {
  const char* bar =
      "[bar]\nlength=1\nviscosity=0\n[left]\nkind=\"obstacle\"\ngap=0.1\nside=\"above\"\n[initial]\n"
      "velocity=\"1+0.2*cos(pi*x)\"\n[time]\nend=2\n[output]\nevery=0.05\n";
  const AccuracyResult result = solve(study_of(bar, {"accuracy.error=1e-2", "method.name=rigid"}));
  EXPECT_TRUE(result.estimate.kept) << result.estimate.doubt;
  Case waves = result.run;
  waves.method = MethodName::characteristics;
  const accuracy::Sample exact = accuracy::sample_of(waves, waves.output_times());
  EXPECT_LE(accuracy::difference(sample_of(result.run, record(result.run)), exact, Goal::displacement), 1e-2);
}

// 40,000 elements to t = 50 take far longer than the half of a second that a check has, a hundredth of them does not.
TEST(AccuracyOnRequest, BeforeALongRunTheForecastIsThatOfACoarserMesh) {
  Case run = parse_scene(rebound, "scene", std::vector<std::string>{"time.end=50"}).run;
  run.elements = 400'000;  // ten seconds and more where the forecast may take half a second
  const auto forecast = accuracy::forecast(run, 0.1);
  ASSERT_TRUE(forecast.estimate) << forecast.why_not;
  EXPECT_LT(forecast.elements, run.elements);
  run.elements = forecast.elements;
  EXPECT_EQ(forecast.estimate->total, accuracy::quick_estimate(run, std::nullopt, 10.0).estimate->total);
}

// An obstacle that is never met adds nothing to the error, whatever a soft stop elsewhere gives way by.
TEST(Estimates, OfABarAtAStopWithALawCountNoDepthOfThatStop) {
  const std::string scene =
      "[bar]\nlength=1.0\nviscosity=0.1\n[left]\nkind=\"obstacle\"\ngap=0.1\n"
      "contact={law=\"spring_damper\",stiffness=10.0}\n[initial]\nvelocity=-1\n[time]\nend=3\n";
  const auto estimate = [&](const std::string& more) {
    return accuracy::quick_estimate(parse_scene(scene + more, "scene").run, {}, 10.0, {}).estimate.value();
  };
  EXPECT_EQ(estimate("[right]\nkind=\"obstacle\"\nside=\"above\"\ngap=5.0\n").penalty, 0.0);
  // One that is met counts with its own depth: some (rho E)^(1/2) V epsilon.
  const double met = estimate("[right]\nkind=\"obstacle\"\nside=\"above\"\ngap=0.2\n").penalty;
  EXPECT_GT(met, 0.0);
  EXPECT_LT(met, 0.01);
}

TEST(SpaceErrorOfALadder, IsThatOfAnOrderThatIsSeenTwiceAndTwoFifthsMore) {
  const MeshStep steps[] = {{8, 16, 256e-6}, {16, 32, 16e-6}, {32, 64, 1e-6}};
  const accuracy::SpaceError error = accuracy::space_error(steps, 4.0);
  EXPECT_NEAR(*error.trusted, 4.0, 1e-12);
  EXPECT_NEAR(error.error, 1.4 * 1e-6 / 15.0, 1e-18);
  EXPECT_NEAR(error.effectivity, 1.4, 1e-12);
}

// Three differences that double show no limit, unless the changes point elsewhere each time, as those of a chatter.
TEST(SpaceErrorOfALadder, DoesNotSettleWhereDifferencesGrowOneWay) {
  const MeshStep growing[] = {{20, 40, 0.0037}, {40, 80, 0.0070, 1.0}, {80, 160, 0.0138, 1.0}};
  EXPECT_FALSE(accuracy::space_error(growing, 1.0).settles);
  EXPECT_TRUE(accuracy::space_error(std::span(growing).first(2), 1.0).settles);
  const MeshStep wandering[] = {{20, 40, 0.0037}, {40, 80, 0.0070, 1.0}, {80, 160, 0.0138, 0.2}};
  EXPECT_TRUE(accuracy::space_error(wandering, 1.0).settles);
}

// With errors h^4 on 16, 32 and 48 elements.
TEST(SpaceErrorOfALadder, TakesMeshesThatAreNoHalves) {
  const auto error_of = [](double elements) { return std::pow(elements, -4.0); };
  const MeshStep steps[] = {{8, 16, error_of(8) - error_of(16)},
                            {16, 32, error_of(16) - error_of(32)},
                            {32, 48, error_of(32) - error_of(48)}};
  const accuracy::SpaceError error = accuracy::space_error(steps, 4.0);
  EXPECT_NEAR(*error.trusted, 4.0, 1e-5);
  EXPECT_NEAR(error.error, 1.4 * error_of(48), 1e-5 * error_of(48));
  EXPECT_NEAR(
      accuracy::space_error(
          accuracy::prolonged({steps[0], steps[1]}, 48, accuracy::expected_order(std::span(steps).first(2), 4.0)), 4.0)
          .error,
      error.error, 1e-5 * error.error);
}

// After orders 4 and 2 it relies on 1 + (2 - 1) / 2. Changes that point apart make a walk of steps that fall by a half.
TEST(SpaceErrorOfALadder, BelievesHalfAnOrderThatFallsAndWalksWhereChangesPointApart) {
  const MeshStep falling[] = {{8, 16, 256e-6}, {16, 32, 16e-6}, {32, 64, 4e-6}};
  EXPECT_DOUBLE_EQ(accuracy::space_error(falling, 4.0).error, 1.4 * 4e-6 / (std::pow(2.0, 1.5) - 1.0));
  const MeshStep apart[] = {{8, 16, 256e-6}, {16, 32, 16e-6}, {32, 64, 1e-6, -1.0}};
  EXPECT_FALSE(accuracy::space_error(apart, 4.0).trusted);
  EXPECT_DOUBLE_EQ(accuracy::space_error(apart, 4.0).error, 1.4 * 1e-6 * 0.5 / std::sqrt(0.75));
}

// Order 5 twice is relied on; 5 after 5.5 falls to that of theory.
TEST(SpaceErrorOfALadder, ReliesOnAnOrderAboveTheTheoryThatDoesNotFallYet) {
  const MeshStep steady[] = {{8, 16, 1024e-6}, {16, 32, 32e-6}, {32, 64, 1e-6}};
  EXPECT_NEAR(*accuracy::space_error(steady, 4.0).trusted, 5.0, 1e-12);
  const MeshStep falling[] = {{8, 16, 1448e-6}, {16, 32, 32e-6}, {32, 64, 1e-6}};
  EXPECT_NEAR(*accuracy::space_error(falling, 4.0).trusted, 4.0, 1e-12);
}

// 7e-6 after 2e-2 is a zero that was met, not an error: the one before, at best of order 4, leaves more.
TEST(SpaceErrorOfALadder, DoesNotBelieveADifferenceThatFallsFasterThanTheTheory) {
  const MeshStep met[] = {{8, 16, 2.2e-2}, {16, 32, 7e-6, -1.0}};
  EXPECT_DOUBLE_EQ(accuracy::space_error(met, 4.0).error, 1.4 * 2.2e-2 / 16.0 * 0.5 / std::sqrt(0.75));
}

TEST(ChangesThatMatter, LeaveOutFlightsAndContactsBelowTheGrain) {
  accuracy::Sample sample;
  sample.end = 10.0;
  sample.speed = {1.0, 0.0};
  const auto add = [&](double time, Change change, double velocity, double impulse) {
    Event event{time, Where::left, 0, change, velocity};
    event.impulse = impulse;
    sample.events.push_back(event);
  };
  add(1.0, Change::closing, -1.0, 0.0);
  add(2.0, Change::opening, 0.0, 1.0);
  add(2.001, Change::closing, -0.001, 1.0);  // a flight of 1e-6
  add(3.0, Change::opening, 0.0, 2.0);
  add(5.0, Change::closing, -1.0, 2.0);
  add(5.001, Change::opening, 0.0, 2.0 + 1e-7);  // a contact of 1e-7
  sample.impulse = {2.0 + 1e-7, 0.0};
  const accuracy::Resolution coarse{.height = 1e-5}, fine{.height = 1e-8};
  EXPECT_EQ(accuracy::changes_that_matter(sample, Where::left, coarse).times, (std::vector<double>{1.0, 3.0}));
  EXPECT_EQ(accuracy::changes_that_matter(sample, Where::left, fine).times.size(), 6u);
}

// The mesh is chosen at epsilon = 0. What four times the elements change at each penalty of the study is below the
// error that was asked for, and so is 16/15 of it or, of order 2, 4/3.
TEST(AccuracyOnRequest, TheMeshOfALimitStudyKeepsTheErrorAtEachPenalty) {
  for (const double viscosity : {0.03, 1.0})
    for (const double error : {1e-3, 1e-5}) {
      const SceneFile scene =
          parse_scene(rebound, "scene",
                      std::array{fmt::format("bar.viscosity={}", viscosity), std::string("left.gap=0.1"),
                                 fmt::format("accuracy.error={}", error)});
      LimitStudy study;
      study.scene = scene.run;
      study.scene.method = penalised_method(scene.run);
      study.scene.mass = common_mass(study.scene);
      const AccuracyResult solved = limit_to_accuracy(study, *scene.accuracy);
      ASSERT_TRUE(solved.estimate.kept) << solved.estimate.doubt;
      for (const double epsilon : natural_penalties(study.scene.scene)) {
        Case run = study.scene;
        run.epsilon = epsilon;
        run.tolerance = Tolerance{1e-10};
        const auto on = [&](std::size_t elements) {
          run.elements = elements;
          return accuracy::sample_of(run, run.output_times());
        };
        EXPECT_LE(4.0 / 3.0 * difference(on(solved.run.elements), on(4 * solved.run.elements), Goal::displacement),
                  error)
            << viscosity << " " << epsilon << " on " << solved.run.elements;
      }
    }
}

}  // namespace
}  // namespace viscobar
