// Studies of bars in line: error estimates, requests, precision, limit, solutions of others, sweeps.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "dynamics/pieces.hpp"
#include "studies/accuracy/quick_estimate.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"
#include "viscobar/studies/judge/judge.hpp"
#include "viscobar/studies/limit/coupling.hpp"
#include "viscobar/studies/limit/limit.hpp"
#include "viscobar/studies/precision/precision.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {
namespace {

using Settings = std::vector<std::string>;

// Two unlike bars that meet, the second stepped.
const std::string met =
    "[[bar]]\nlength = 1.0\nviscosity = 0.1\nvelocity = 1.0\n[[bar]]\nlength = 0.7\ndensity = 2.0\nmodulus = "
    "3.0\nviscosity = 0.2\nvelocity = 0.0\n[[bar]]\nlength = 0.6\nviscosity = 0.1\nvelocity = 0.0\n[[joint]]\nkind = "
    "\"contact\"\ngap = 0.05\n[[joint]]\nkind = \"bonded\"\n[time]\nend = 2.0\n[output]\nevery = 0.1\n";

Case scene(Settings settings) {
  settings.emplace_back("contact.restitution=0");
  return parse_scene(met, "", settings).run;
}

// In each bar so many times the elements.
Case finer(Case run, std::size_t times) {
  const Mesh mesh = run.mesh();
  run.bar_meshes = *mesh.members;
  run.elements = 0;
  for (Mesh& own : run.bar_meshes) run.elements += own.elements *= times;
  return run;
}

// The largest difference of displacements at the nodes of the coarser one.
double apart(const Recording& coarse, const Recording& fine, const Scene& scene, std::size_t times) {
  const auto a = pieces_of(scene, coarse.mesh), b = pieces_of(scene, fine.mesh);
  double largest = 0.0;
  for (std::size_t k = 0; k < coarse.times.size(); ++k)
    for (std::size_t p = 0; p < a.size(); ++p)
      for (std::size_t j = 0; j < a[p].mesh.nodes(); ++j)
        largest = std::max(
            largest, std::abs(coarse.displacement(k)[a[p].first + j] - fine.displacement(k)[b[p].first + times * j]));
  return largest;
}

// An estimate is no less than the error, which a mesh with eight times the elements tells to a part of 8^-3, and within
// the thirtyfold of it, which its safeties come to, and the layer that an impact of speed 1 sends out between outputs.
TEST(ChainAccuracy, TheEstimateOfARunIsThatOfItsError) {
  for (const auto& settings :
       {Settings{"method.name=rigid", "mesh.elements=80"}, Settings{"method.name=rigid", "mesh.elements=160"},
        Settings{"method.name=arkode", "mesh.elements=80", "contact.epsilon=1e-5"}}) {
    const Case run = scene(settings);
    const auto found = accuracy::quick_estimate(run, std::nullopt, 60.0);
    ASSERT_TRUE(found.estimate) << found.why_not;
    Case best = finer(run, 8);
    best.method = MethodName::rigid;
    best.tolerance = best.tolerance.with_relative(1e-9);
    const double error = apart(record(run), record(best), run.scene, 8);
    EXPECT_GE(found.estimate->total, error) << settings[0] << settings[1];
    double layer = 0.0;
    for (const Piece& piece : pieces_of(run.scene, run.mesh()))
      layer = std::max(layer, std::pow(piece.mesh.spacing(), 2) * piece.bar.density / piece.bar.viscosity);
    EXPECT_LE(found.estimate->total, 30.0 * error + 1.4 * 0.0039 * layer) << settings[0] << settings[1];
  }
}

TEST(ChainAccuracy, ABarOfFewElementsHasNoEstimateAndSaysWhy) {
  const auto found = accuracy::quick_estimate(scene({"mesh.elements=20", "method.name=rigid"}), std::nullopt, 60.0);
  EXPECT_FALSE(found.estimate);
  EXPECT_NE(found.why_not.find("in each bar"), std::string::npos) << found.why_not;
}

// Bars of four elements beside a long one: what a run costs is estimated on their own meshes, not on a part of them.
TEST(ChainAccuracy, ARequestIsKeptOnBarsThatAreShort) {
  AccuracyStudy study;
  study.scene = parse_scene(
                    "[[bar]]\nlength = 0.3\nviscosity = 1.0\nvelocity = 1.0\n[[bar]]\nlength = 5.0\nviscosity = "
                    "0.1\nvelocity = -1.0\n[[bar]]\nlength = 0.3\nviscosity = 1.0\nvelocity = 0.0\n[[joint]]\nkind = "
                    "\"contact\"\ngap = 0.1\n[[joint]]\nkind = \"spring\"\nstiffness = 0.1\n[time]\nend = "
                    "0.5\n[method]\nname = \"cvode\"\n",
                    "")
                    .run;
  study.request.error = 1e-2;
  study.request.given.method = true;
  const AccuracyResult result = solve(study);
  EXPECT_TRUE(result.estimate.kept) << result.estimate.doubt;
}

TEST(ChainAccuracy, ARequestIsKept) {
  for (const Goal of : {Goal::displacement, Goal::contact_times, Goal::impulse}) {
    AccuracyStudy study;
    study.scene = scene({"method.name=rigid"});
    study.request.error = of == Goal::displacement ? 1e-4 : 1e-3;
    study.request.of = of;
    study.request.given.method = study.request.given.restitution = true;
    const AccuracyResult result = solve(study);
    EXPECT_TRUE(result.estimate.kept) << name(of) << result.estimate.doubt;
    Case best = finer(result.run, 4);
    best.tolerance = best.tolerance.with_relative(1e-10);
    const Recording fine = record(best), own = record(result.run);
    if (of == Goal::displacement) {
      EXPECT_LE(apart(own, fine, best.scene, 4), 1e-4);
    } else if (of == Goal::impulse) {
      EXPECT_NEAR(own.statistics.account->joints.at(0).impulse, fine.statistics.account->joints.at(0).impulse, 1e-3);
    }
    if (of != Goal::contact_times) continue;
    ASSERT_EQ(own.events.size(), fine.events.size());
    for (std::size_t k = 0; k < own.events.size(); ++k) EXPECT_NEAR(own.events[k].time, fine.events[k].time, 1e-3);
  }
}

// Unlike bars that touch have one velocity at once, by (rho eta)^(1/2) of each; their nodes have another, by rho h,
// until the layer is as wide as an element, t = rho h^2 / eta. The largest error over all times is theirs, of order
// two; later the traces are of order 3.5 or more (docs/bars-in-line.md).
TEST(ChainPrecision, SpaceErrorsFallLikeThoseOfTheFirstMomentsOfATouch) {
  PrecisionStudy study;
  study.scene = scene({"mesh.elements=40", "mesh.mass=fourth_order", "time.end=1.0"});
  study.elements = {40, 80};
  study.methods = {MethodName::rigid};
  study.tolerances = {1e-4, 1e-6};
  study.repeat = 1;
  study.seconds = 20.0;
  const PrecisionResult result = precision_of(study);
  ASSERT_EQ(result.parts.size(), 2U);
  ASSERT_TRUE(result.parts[0].space && result.parts[1].space) << result.no_reference;
  EXPECT_NEAR(std::log2(*result.parts[0].space / *result.parts[1].space), 2.0, 0.3);
  ASSERT_EQ(result.rows.size(), 4U);
  for (const PrecisionRow& row : result.rows) EXPECT_LT(row.time_error.value(), 100.0 * row.setting) << row.label;
  study.elements = {40, 81};
  EXPECT_THROW((void)precision_of(study), std::invalid_argument);
}

// The scheme stops nodes as the dashpot of a penalty with restitution 0 does.
TEST(ChainLimit, ThePenaltyTendsToTheSchemeWithItsLaw) {
  LimitStudy study;
  study.scene = scene({"mesh.elements=40", "time.end=1.0"});
  study.epsilons = {1e-3, 1e-4, 1e-5, 1e-6};
  study.budget = 20.0;
  const LimitResult result = limit_of(study);
  EXPECT_EQ(result.orders.at(0).verdict, Verdict::converges);
  ASSERT_TRUE(result.rows.back().difference_to_scheme_limit);
  // A node that a dashpot stops goes sqrt(epsilon) deep at most, at a speed of 1.
  EXPECT_LT(*result.rows.back().difference_to_scheme_limit, std::sqrt(1e-6));
}

// A node more or less in a bar hides a power of h, and so does a reference whose error is of order 2, too.
TEST(ChainLimit, BothLimitsTendToTheBarsOwnMotionLikeTheSquareOfH) {
  LimitStudy study;
  study.scene = scene({"mesh.mass=consistent", "time.end=1.0"});
  study.elements = {10, 20, 40};
  study.epsilons = {1e-3, 1e-4, 1e-5};
  study.budget = 20.0;
  const LimitResult result = limit_of(study);
  ASSERT_TRUE(result.own_motion);
  const std::vector<OwnMotion::Mesh>& meshes = result.own_motion->meshes;
  ASSERT_EQ(meshes.size(), 3U);
  for (std::size_t m = 0; m < 3; ++m) EXPECT_EQ(meshes[m].elements, meshes[0].elements << m);
  EXPECT_LT(10.0 * result.own_motion->error, meshes[2].scheme);
  for (const auto& order : {result.own_motion->penalty, result.own_motion->scheme}) {
    ASSERT_TRUE(order);
    EXPECT_NEAR(order->order, 2.0, 0.05);
  }
  // The joint's element has no length, and no part in h.
  const CouplingResult found = balance_errors(study, result);
  ASSERT_TRUE(found.coupling) << found.reason;
  EXPECT_NEAR(found.coupling->mesh_order, 2.0, 0.1);
  for (std::size_t m = 0; m < 3; ++m) EXPECT_DOUBLE_EQ(found.coupling->meshes.at(m).spacing, meshes[m].spacing);
}

// Both bars fly on, so that the depth of their contact is the difference of displacements a million times as large: of
// fewer digits than the tolerance asks the contact's nodes for.
TEST(ChainLimit, AContactOfFlyingBarsTakesAStiffSpringAndATightTolerance) {
  std::vector<double> found;
  for (const char* method : {"arkode", "cvode", "ida"}) {
    const Case run =
        parse_scene(
            "[[bar]]\nlength = 1.0\nvelocity = 1.0\nviscosity = 0.1\n[[bar]]\nlength = 1.0\nviscosity = "
            "0.1\n[[joint]]\nkind = \"contact\"\n[time]\nend = 3.0\n[mesh]\nelements = 40\n",
            "",
            Settings{fmt::format("method.name={}", method), "contact.epsilon=1e-6", "method.relative_tolerance=1e-10"})
            .run;
    const Recording done = record(run);
    EXPECT_TRUE(done.statistics.completed) << method;
    found.push_back(done.displacement(done.times.size() - 1)[0]);
    EXPECT_NEAR(found.back(), found.front(), 100.0 * 1e-10 * 2.0) << method;
  }
}

// A coarse run of ours as that of another program: its columns are as far away as runs are, and its contact is found;
// one without contact misses it.
TEST(ChainJudge, JudgesColumnsOfEndsGaugesAndJoints) {
  const Case run = scene({"mesh.elements=40", "method.name=rigid", "output.every=0.02"});
  Recording theirs = record(run);
  JudgeStudy study;
  study.scene = scene({});
  study.request.error = 1e-3;
  study.request.relative = true;
  study.most_seconds = 20.0;
  const viscobar::Setup setup = resolve(run);
  const std::size_t node = setup.system().elements().joints().at(0).node;
  TheirSolution one;
  one.label = "coarse", one.times = theirs.times;
  const auto column = [&](const std::string& name, std::size_t j) {
    one.columns.push_back({name, {}});
    for (std::size_t k = 0; k < theirs.times.size(); ++k)
      one.columns.back().values.push_back(theirs.displacement(k)[j]);
  };
  column("u_left", 0), column("u_right", setup.mesh.elements), column("u_left:1", node - 1), column("u_right:1", node);
  column("u@2.3", setup.mesh.elements);
  study.solutions.push_back(one);
  one.label = "apart";
  for (double& u : one.columns[3].values) u += 1.0;
  study.solutions.push_back(one);
  const JudgeResult result = judge(study);
  for (const JudgedColumn& judged : result.solutions[0].columns) EXPECT_LT(judged.largest, 1e-3) << judged.name;
  ASSERT_EQ(result.solutions[0].contacts.size(), 1U);
  EXPECT_EQ(result.solutions[0].contacts[0].where, Where::joint);
  EXPECT_EQ(result.solutions[0].contacts[0].verdict, ContactVerdict::found);
  ASSERT_EQ(result.solutions[1].count(ContactVerdict::missed), 1U);
  EXPECT_NEAR(result.solutions[1].columns[3].largest, 1.0, 1e-3);
  study.solutions[0].columns[2].name = "force:2";
  EXPECT_THROW((void)judge(study), std::invalid_argument);  // bonded
}

// The first of equal elastic bars stops: N = Z v / 2 for 2 L/c, whose impulse is its momentum. A bonded joint has
// no contact.
TEST(ChainSweep, ARowHasTheContactsOfEachJoint) {
  const std::string two =
      "[[bar]]\nlength = 1.0\nvelocity = 1.0\n[[bar]]\nlength = 0.4\nvelocity = 0.0\n[[bar]]\nlength = 0.6\n"
      "velocity = 0.0\n[[joint]]\nkind = \"contact\"\ngap = 0.05\n[[joint]]\nkind = \"bonded\"\n[time]\nend = 3.0\n";
  SweepPlan plan{.keys = {{"joint.1.gap", std::vector<double>{0.05, 10.0}}}, .joints = 2};
  const std::vector<QuantityColumn> columns = plan.columns();
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const SweepRow row = run_case(two, {.index = i, .settings = plan.settings(i)}).value();
    ASSERT_TRUE(row.completed) << row.error;
    const auto value = [&](const std::string& name) {
      return row.column(
          static_cast<std::size_t>(std::ranges::find(columns, name, &QuantityColumn::name) - columns.begin()));
    };
    const double closed = i == 0 ? 1.0 : 0.0;
    EXPECT_EQ(value("closings_joint:1"), closed);
    EXPECT_NEAR(value("time_in_contact_joint:1"), 2.0 * closed, 1e-12);
    EXPECT_NEAR(value("impulse_joint:1"), closed, 1e-12);
    EXPECT_NEAR(value("max_reaction_joint:1"), 0.5 * closed, 1e-12);
    EXPECT_TRUE(std::isnan(value("closings_joint:2")));
  }
}

}  // namespace
}  // namespace viscobar
