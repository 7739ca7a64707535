// The promises of an ensemble to its caller.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <stdexcept>

#include "dynamics/gauge.hpp"
#include "ensemble/random_ensemble.hpp"
#include "viscobar/case/recording.hpp"

namespace {

using namespace viscobar;

const std::string thrown = thrown_between_walls(24, 3.0);

void expect_same(const EnsembleResult& a, std::size_t of_a, const EnsembleResult& b, std::size_t of_b) {
  for (std::size_t o = 0; o < a.outputs.size(); ++o) {
    const std::size_t width = a.outputs[o].width();
    for (std::size_t k = 0; k < width; ++k) {
      const double mine = a.values[o][of_a * width + k], theirs = b.values[o][of_b * width + k];
      EXPECT_TRUE(mine == theirs || (std::isnan(mine) && std::isnan(theirs))) << a.outputs[o].name << " " << of_a;
    }
  }
  EXPECT_EQ(a.steps[of_a], b.steps[of_b]);
}

TEST(Ensemble, IsTheSameBitForBitInAnyBatchAndOnAnyNumberOfThreads) {
  TextEnsemble made{thrown, {"bar.viscosity", "left.gap"}, {{}, {}}};
  for (std::size_t i = 0; i < 1100; ++i) {
    made.values[0].push_back(0.01 * std::pow(100.0, static_cast<double>(i % 37) / 36.0));
    made.values[1].push_back(0.05 + 0.25 * static_cast<double>(i % 23) / 22.0);
  }
  EnsembleStudy study = made.study();
  study.outputs = {"u_left@0.1", "events:4", "impulse_left", "final"};
  study.error = 1e-3;
  study.threads = 1;
  const EnsembleResult one = ensemble(study);
  study.threads = 3;
  const EnsembleResult three = ensemble(study);
  for (std::size_t i = 0; i < one.bars; ++i) expect_same(one, i, three, i);
  TextEnsemble reversed = made;
  for (auto& list : reversed.values) std::ranges::reverse(list), list.resize(333);
  EnsembleStudy part = reversed.study();
  part.outputs = study.outputs, part.error = study.error;
  const EnsembleResult of_part = ensemble(part);
  for (std::size_t i = 0; i < of_part.bars; ++i) expect_same(of_part, i, one, one.bars - 1 - i);
}

TEST(Ensemble, FinalIsTheStateOfAllNodesAtTheEndSideBySideAndAlone) {
  TextEnsemble made{thrown, {"left.gap"}, {{0.1, 0.15, 0.2}}};
  EnsembleStudy study = made.study();
  study.outputs = {"impulse_left", "final", "u_left@3", "u_right@3"};
  study.error = 1e-3;
  for (const bool lanes : {true, false}) {
    study.lanes = lanes;
    const EnsembleResult found = ensemble(study);
    ASSERT_EQ(found.outputs[1].shape, (std::vector<std::size_t>{2, 25}));
    for (std::size_t i = 0; i < found.bars; ++i) {
      const std::span<const double> all = std::span(found.values[1]).subspan(50 * i, 50);
      for (const double value : all) EXPECT_TRUE(std::isfinite(value)) << lanes << i;
      EXPECT_EQ(all[0], found.values[2][2 * i + 1]) << lanes << i;
      EXPECT_EQ(all[24], found.values[3][2 * i + 1]) << lanes << i;
    }
  }
}

TEST(Ensemble, TellsImpulsesAndPeaksOfTheEndThatIsNamed) {
  // Thrown to the left, so that the left stop takes the larger blow.
  const TextEnsemble made{thrown, {"right.gap"}, {{0.1, 0.6, 50.0}}};
  EnsembleStudy study = made.study();
  study.outputs = {"impulse_left", "peak_left", "impulse_right", "peak_right"};
  const EnsembleResult found = ensemble(study);
  for (std::size_t i = 0; i < found.bars; ++i) {
    const RunAccount account = record(study.model(std::array{made.values[0][i]})).statistics.account.value();
    EXPECT_GT(account.left.peak_reaction, account.right.peak_reaction);
    EXPECT_EQ(found.values[0][i], account.left.impulse);
    EXPECT_EQ(found.values[1][i], account.left.peak_reaction);
    EXPECT_EQ(found.values[2][i], account.right.impulse);
    EXPECT_EQ(found.values[3][i], account.right.peak_reaction);
  }
}

// No step of the scheme sees the first force of an impact, and the one that stops a node with mass grows with their
// number.
TEST(Ensemble, PeaksUnderAnErrorAreThoseOfRigid) {
  for (const char* mass : {"fourth_order", "redistributed"}) {
    TextEnsemble made{thrown, {"left.gap"}, {{0.1, 0.15, 0.2}}};
    made.scene.replace(made.scene.find("fourth_order"), 12, mass);
    EnsembleStudy study = made.study();
    study.outputs = {"peak_left"};
    study.error = 1e-3;
    const EnsembleResult found = ensemble(study), truth = truth_of(made, study.outputs);
    for (std::size_t i = 0; i < found.bars; ++i)
      EXPECT_NEAR(found.values[0][i], truth.values[0][i], 1e-3 * truth.values[0][i]) << mass << i;
  }
}

TEST(Ensemble, OfASchemeWhoseStepIsLeftOpenGivesEachBarItsOwn) {
  // The step follows the speed of waves, which the modulus changes.
  TextEnsemble made =
      by_method(TextEnsemble{thrown, {"bar.modulus"}, {{1.0, 4.0, 16.0}}}, "name = \"fully_discrete\"\n");
  for (int turn = 0; turn < 2; ++turn, std::ranges::reverse(made.values[0])) {
    EnsembleStudy study = made.study();
    study.outputs = {"u_left@3"};
    const EnsembleResult found = ensemble(study);
    for (std::size_t i = 0; i < found.bars; ++i) {
      const Recording own = record(study.model(std::array{made.values[0][i]}));
      EXPECT_EQ(found.steps[i], own.statistics.steps) << made.values[0][i];
      EXPECT_EQ(found.values[0][2 * i + 1], own.displacement(own.times.size() - 1)[0]) << made.values[0][i];
    }
    EXPECT_NE(found.steps[0], found.steps[2]);
  }
}

// The truth is the same semi-discrete bar by rigid at 1e-10. Of 10,000 bars 1 % lie above their estimate, 2 above
// three times it (measure_ensemble errors 100 5).
TEST(Ensemble, ErrorsOfRandomBarsLieWithinThreeTimesTheirEstimates) {
  std::mt19937_64 random(21);
  std::size_t compared = 0, far_above = 0;
  for (int scene = 0; scene < 12; ++scene) {
    TextEnsemble made = random_ensemble(random, 20);
    for (double& gap : made.values[1]) gap = std::max(gap, 0.02);
    EnsembleStudy study = made.study();
    const double end = made.run(made.of(0)).end;
    study.outputs = {fmt::format("u_left@{}", end / 64), fmt::format("u_right@{}", end / 64)};
    study.error = scene % 2 == 0 ? 1e-2 : 1e-3;
    const EnsembleResult found = ensemble(study);
    const EnsembleResult truth = truth_of(made, study.outputs);
    for (std::size_t i = 0; i < found.bars; ++i) {
      ASSERT_EQ(found.status[i], BarStatus::kept);
      EXPECT_LE(found.error[i], *study.error);
      ++compared;
      far_above += error_of(found, truth, i, 2) > 3.0 * found.error[i];
    }
  }
  EXPECT_EQ(compared, 240u);
  EXPECT_LE(far_above, 4u);
}

// Between two ends that are held, gauges and the final state alone tell of the error.
TEST(Ensemble, ErrorsOfGaugesAndFinalStatesBetweenFixedEndsAreAsked) {
  TextEnsemble made{
      "[bar]\nlength=1\nmodulus=3\nviscosity=0.1\n[left]\nkind=\"fixed\"\n[right]\nkind=\"fixed\"\n[initial]\n"
      "velocity=-1\n[mesh]\nelements=6\nmass=\"fourth_order\"\n[time]\nend=2\n",
      {"bar.viscosity"},
      {{0.05, 0.1, 0.2}}};
  for (const char* output : {"gauge:0.3@0.2", "final"})
    for (const bool lanes : {true, false}) {
      EnsembleStudy study = made.study();
      study.outputs = {output};
      study.error = 1e-3;
      study.lanes = lanes;
      const EnsembleResult found = ensemble(study), truth = truth_of(made, study.outputs);
      const std::size_t width = found.outputs[0].width(), stride = width == 14 ? 1 : 4, count = width == 14 ? 7 : width;
      for (std::size_t i = 0; i < found.bars; ++i) {
        double apart = 0.0, size = 0.0;
        for (std::size_t k = 0; k < count; k += stride) {
          const double exact = truth.values[0][i * width + k];
          apart = std::max(apart, std::abs(found.values[0][i * width + k] - exact));
          size = std::max(size, std::abs(exact));
        }
        EXPECT_EQ(found.status[i], BarStatus::kept) << output << lanes;
        EXPECT_LE(apart, 3.0 * found.error[i] * size) << output << lanes << i;
        EXPECT_LE(found.error[i], 1e-3) << output << lanes << i;
      }
    }
}

// An end mass that strikes in tension is pulled off at once, which (2.8) tells to order 1 by the phase of its step, and
// a node that rebounds comes two steps late: neither is told side by side. Of 1,600 bars with end masses 2 have errors
// above three times their estimates, of 2,000 with restitution 15 (measure_ensemble errors 20 5 KIND).
TEST(Ensemble, EndMassesThatArePulledOffAndReboundsGoAloneWithinTheirEstimates) {
  for (const char* more : {"", "[contact]\nrestitution=0.6\n"}) {
    TextEnsemble made{std::string("[bar]\nlength=1\nviscosity=0.01\n[left]\nkind=\"obstacle\"\ngap=0.1\nmass=0.35\n"
                                  "[initial]\nvelocity=\"-cos(pi*x)\"\n[mesh]\nelements=20\nmass=\"fourth_order\"\n"
                                  "[time]\nend=1.5\n") +
                          more,
                      {"left.gap"},
                      {{}}};
    for (int i = 0; i < 20; ++i) made.values[0].push_back(0.34 + 0.0013 * i);
    EnsembleStudy study = made.study();
    study.outputs = {"u_left@0.01"};
    study.error = 1e-3;
    const EnsembleResult found = ensemble(study);
    const EnsembleResult truth = truth_of(made, study.outputs);
    EXPECT_GT(std::ranges::count(found.ways, BarWay::alone), 5) << more;
    for (std::size_t i = 0; i < found.bars; ++i) {
      EXPECT_EQ(found.status[i], BarStatus::kept);
      EXPECT_LE(error_of(found, truth, i, 1), 3.0 * found.error[i]) << more << made.values[0][i];
    }
  }
}

// A contact that changes just before the end may do so behind it in another run.
TEST(Ensemble, AContactTimeJustBeforeTheEndIsWrongByNoMoreThanItsEstimate) {
  TextEnsemble made{
      "[bar]\nlength = 1.0\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[initial]\nvelocity = "
      "-1.0\n[time]\nend = 2.0\n[mesh]\nelements = 10\n",
      {"left.gap"},
      {{}}};
  for (int i = 0; i < 20; ++i) made.values[0].push_back(1.98 + 0.001 * i);
  EnsembleStudy study = made.study();
  study.outputs = {"events:2"};
  study.error = 1e-2;
  const EnsembleResult found = ensemble(study);
  for (std::size_t i = 0; i < found.bars; ++i) {
    EXPECT_EQ(found.ways[i], BarWay::lanes);
    const double told = std::isnan(found.values[0][2 * i]) ? 2.0 : found.values[0][2 * i];
    EXPECT_LE(std::abs(told - made.values[0][i]) / 2.0, found.error[i]) << made.values[0][i];
  }
}

// Two tolerances may leave out the same bounces before a rest, and tell the changes behind them in their place.
TEST(Ensemble, ContactTimesCountTheBouncesBelowTheToleranceOrAreNotKept) {
  constexpr double end = 3.0;
  for (const char* restitution : {"0.1", "0.3", "0.6"}) {
    TextEnsemble made{
        std::string("[bar]\nlength = 1.0\nviscosity = 0.175\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[right]\nkind = "
                    "\"obstacle\"\ngap = 0.15\n[initial]\nvelocity = -1.0\n[time]\nend = 3.0\n[mesh]\nelements = "
                    "20\n[contact]\nrestitution = ") +
            restitution + "\n",
        {"left.gap"},
        {{}}};
    for (int i = 0; i < 20; ++i) made.values[0].push_back(0.17 + 0.0025 * i);
    EnsembleStudy study = made.study();
    study.outputs = {"events:8"};
    study.error = 1e-3;
    const EnsembleResult found = ensemble(study);
    const EnsembleResult truth = truth_of(made, study.outputs);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < found.bars; ++i) {
      if (found.status[i] != BarStatus::kept) continue;
      ++kept;
      for (std::size_t k = 0; k < 8; ++k) {
        const double time = found.values[0][8 * i + k], of_truth = truth.values[0][8 * i + k];
        EXPECT_TRUE(std::abs(time - of_truth) <= *study.error * end || (std::isnan(time) && std::isnan(of_truth)))
            << restitution << " " << made.values[0][i] << " " << k;
      }
    }
    EXPECT_GT(kept, 15u) << restitution;
  }
}

// The end lies on its obstacle at all of the times that runs are compared at, but for its way there.
TEST(Ensemble, AWayBetweenTheTimesThatAreComparedHasAnError) {
  TextEnsemble made{
      "[bar]\nlength = 1.0\nviscosity = 0.5\n[left]\nkind = \"obstacle\"\ngap = 0.04\n[right]\nkind = \"fixed\"\n"
      "[initial]\nvelocity = \"-cos(pi*x/2)\"\n[load]\ndensity = -0.5\n[time]\nend = 3.75\n[mesh]\nelements = "
      "36\nmass = \"redistributed\"\n",
      {"left.gap"},
      {{0.035, 0.04, 0.045}}};
  EnsembleStudy study = made.study();
  study.outputs = {"u_left@0.029296875"};
  study.error = 1e-3;
  const EnsembleResult found = ensemble(study);
  const EnsembleResult truth = truth_of(made, study.outputs);
  for (std::size_t i = 0; i < found.bars; ++i) {
    EXPECT_EQ(found.ways[i], BarWay::lanes);
    EXPECT_LE(error_of(found, truth, i, 1), found.error[i]) << made.values[0][i];
  }
}

// In free flight at speed 1 the touch is at t = gap, and both step sizes may put it at the same time.
TEST(Ensemble, AContactTimeIsNoBetterThanAStep) {
  TextEnsemble made{
      "[bar]\nlength = 1.0\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[initial]\nvelocity = "
      "-1.0\n[time]\nend = 0.5\n[mesh]\nelements = 10\n",
      {"left.gap"},
      {{}}};
  for (int i = 0; i < 60; ++i) made.values[0].push_back(0.1 + 0.2 * i / 59.0);
  for (const double error : {1e-2, 1e-3}) {
    EnsembleStudy study = made.study();
    study.outputs = {"events:1"};
    study.error = error;
    const EnsembleResult found = ensemble(study);
    for (std::size_t i = 0; i < found.bars; ++i) {
      EXPECT_EQ(found.status[i], BarStatus::kept);
      EXPECT_EQ(found.ways[i], error < 5e-3 ? BarWay::alone : BarWay::lanes);
      EXPECT_LE(std::abs(found.values[0][i] - made.values[0][i]) / 0.5, found.error[i]) << error << " " << i;
    }
  }
}

TextEnsemble struck_bars() {
  TextEnsemble made{
      "[[bar]]\nlength = 0.5\nviscosity = 0.02\nvelocity = 1.0\n[[bar]]\nlength = 1.0\nviscosity = 0.02\n[[joint]]\n"
      "kind = \"contact\"\ngap = 0.05\n[right]\nkind = \"fixed\"\n[initial]\nvelocity = 0.0\n[time]\nend = 2.0\n"
      "[mesh]\nelements = 30\n",
      {"bar.2.modulus", "joint.1.gap"},
      {{}, {}}};
  for (int i = 0; i < 12; ++i) {
    made.values[0].push_back(0.5 + 0.1 * i);
    made.values[1].push_back(0.03 + 0.01 * (i % 5));
  }
  return made;
}

// By the scene's own method: bits of a plain run.
TEST(Ensemble, OfBarsInLineTellsWhatARunTells) {
  TextEnsemble made = struck_bars();
  made.scene += "[method]\nname = \"rigid\"\n[output]\nevery = 0.25\n";
  EnsembleStudy study = made.study();
  study.outputs = {"u_right:1@0.25", "gauge:1@0.25", "events:3", "impulse_joint:1", "peak_joint:1", "force:1@0.25"};
  const EnsembleResult found = ensemble(study);
  ASSERT_EQ(found.bars, 12u);
  for (std::size_t i = 0; i < found.bars; ++i) {
    EXPECT_EQ(found.status[i], BarStatus::kept);
    EXPECT_EQ(found.ways[i], BarWay::alone);
    const Case run = made.run(made.of(i));
    const Recording truth = record(run);
    const BarSystem system = resolve(run).system();
    const JointNodes joint = system.elements().joints().front();
    const Gauge gauge(system.mesh(), run.scene, 1.0);
    const std::size_t times = truth.times.size();
    ASSERT_EQ(found.outputs[0].width(), times);
    for (std::size_t k = 0; k < times; ++k) {
      EXPECT_EQ(found.values[0][i * times + k], truth.displacement(k)[joint.node]);
      EXPECT_EQ(found.values[1][(i * times + k) * 4 + 3], gauge(truth.displacement(k), truth.velocity(k)).stress);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const double change = found.values[2][3 * i + k];
      if (k < truth.events.size())
        EXPECT_EQ(change, truth.events[k].time);
      else
        EXPECT_TRUE(std::isnan(change));
    }
    EXPECT_GE(truth.events.size(), 1u);
    const ContactAccount& account = truth.statistics.account->joints.front();
    EXPECT_EQ(found.values[3][i], account.impulse);
    EXPECT_EQ(found.values[4][i], account.peak_reaction);
    EXPECT_GT(account.impulse, 0.0);
  }
  EXPECT_GT(std::ranges::max(found.values[5]), 0.0);
}

TEST(Ensemble, OfBarsInLineKeepsItsErrorOrSaysThatItDoesNot) {
  TextEnsemble made = struck_bars(), exact = by_method(struck_bars(), "name = \"rigid\"\nrelative_tolerance = 1e-11\n");
  EnsembleStudy study = made.study(), truth = exact.study();
  study.outputs = truth.outputs = {"u_left:1@0.03", "impulse_joint:1", "events:2"};
  study.error = 1e-4;
  const EnsembleResult found = ensemble(study), true_values = ensemble(truth);
  for (std::size_t i = 0; i < found.bars; ++i) {
    EXPECT_EQ(found.status[i], BarStatus::kept);
    EXPECT_LE(error_of(found, true_values, i, 2), 3.0 * found.error[i]) << i;
  }
  study.outputs = {"force:2@0.1"};
  EXPECT_THROW(ensemble(study), std::invalid_argument) << "two bars have one joint";
}

// A bar that falls at speed 1 on an obstacle below all of it, which stops it node by node: at rest at -gap.
TEST(Ensemble, AboveASpanObstacleTheErrorIsEstimatedOrNotKept) {
  TextEnsemble made{
      "[bar]\nlength = 1.0\nviscosity = 0.1\n[span]\ngap = 0.3\n[initial]\nvelocity = -1.0\n[time]\nend = "
      "1.0\n[mesh]\nelements = 10\n",
      {"span.gap"},
      {{0.11, 0.23, 0.37}}};
  EnsembleStudy study = made.study();
  study.outputs = {"u_left@0.1"};
  study.error = 1e-2;
  const EnsembleResult found = ensemble(study);
  const std::size_t width = found.outputs[0].width();
  for (std::size_t i = 0; i < found.bars; ++i) {
    EXPECT_EQ(found.status[i], BarStatus::kept);
    for (std::size_t k = 0; k < width; ++k)
      EXPECT_NEAR(found.values[0][i * width + k], -std::min(0.1 * static_cast<double>(k), made.values[0][i]),
                  found.error[i] * made.values[0][i])
          << i << " " << k;
  }
}

TEST(Ensemble, ABarWhoseSceneCannotBeRunIsToldAndNoOtherSuffers) {
  const TextEnsemble made{thrown, {"bar.viscosity"}, {{0.1, -1.0, 0.2, std::nan("")}}};
  EnsembleStudy study = made.study();
  study.outputs = {"impulse_left"};
  study.error = 1e-3;
  const EnsembleResult found = ensemble(study);
  EXPECT_EQ(found.status, (std::vector{BarStatus::kept, BarStatus::faulty, BarStatus::kept, BarStatus::faulty}));
  EXPECT_TRUE(std::isnan(found.values[0][1]));
  EXPECT_TRUE(std::isfinite(found.values[0][2]));
  ASSERT_EQ(found.messages.size(), 2u);
  EXPECT_EQ(found.messages[0].first, 1u);
  EXPECT_NE(found.messages[0].second.find("bar.viscosity"), std::string::npos);
}

TEST(Ensemble, WhatDoesNotFitIntoLanesRunsAlone) {
  for (const char* more : {"[load]\ndensity = \"-sin(t*x)\"\n", "[contact]\nepsilon = 1e-5\n"}) {
    TextEnsemble made{thrown, {"bar.viscosity"}, {{0.1, 0.2}}};
    made.scene += more;
    EnsembleStudy study = made.study();
    study.outputs = {"u_left@0.5"};
    study.error = 1e-3;
    const EnsembleResult found = ensemble(study);
    for (std::size_t i = 0; i < found.bars; ++i) {
      EXPECT_EQ(found.ways[i], BarWay::alone);
      EXPECT_EQ(found.status[i], BarStatus::kept);
    }
  }
}

// Sections that differ from bar to bar share no pattern, so that none of these bars is in lanes, whichever is the
// first.
TEST(Ensemble, ABarsWayAndBitsDependOnNoOtherBar) {
  TextEnsemble made{
      "[bar]\nlength=1\nviscosity=0.05\nsection=\"1+p*x\"\n[parameters]\np=1\n[left]\nkind=\"obstacle\"\ngap=0.2\n"
      "[right]\nkind=\"fixed\"\n[initial]\nvelocity=\"0.3*sin(5*x)\"\n[mesh]\nelements=16\n[time]\nend=3\n",
      {"parameters.p"},
      {{0.5, 1.0, 1.5, 2.0}}};
  EnsembleStudy study = made.study();
  study.outputs = {"final"};
  study.error = 1e-3;
  const EnsembleResult there = ensemble(study);
  std::ranges::reverse(made.values[0]);
  EnsembleStudy backwards = made.study();
  backwards.outputs = study.outputs, backwards.error = study.error;
  const EnsembleResult back = ensemble(backwards);
  const std::size_t width = there.outputs[0].width();
  for (std::size_t i = 0; i < there.bars; ++i) {
    EXPECT_EQ(there.ways[i], back.ways[there.bars - 1 - i]);
    for (std::size_t k = 0; k < width; ++k)
      EXPECT_EQ(there.values[0][i * width + k], back.values[0][(there.bars - 1 - i) * width + k]) << i << " " << k;
  }
}

// Waves of the smallest elements, which nothing damps, are no steps' to resolve: halved steps told an error of a fifth
// of what it was.
TEST(Ensemble, UndampedBarsOfUnequalElementsAreWithinTheirEstimates) {
  for (const char* mass : {"fourth_order", "consistent", "lumped"})
    for (const double viscosity : {0.0, 1e-3, 0.05}) {  // damping ratios 0, 0.04 and 2
      TextEnsemble made{fmt::format("[bar]\nlength=1\nviscosity={}\n[parameters]\nq=5\n[left]\nkind=\"obstacle\"\n"
                                    "gap=0.2\n[right]\nkind=\"fixed\"\n[initial]\nvelocity=\"0.3*sin(q*x)\"\n[mesh]\n"
                                    "elements=11\ngrading=6.9\nmass=\"{}\"\n[time]\nend=3\n",
                                    viscosity, mass),
                        {"parameters.q", "left.gap"},
                        {{3.0, 5.0, 7.0, 9.0, 11.0}, {0.05, 0.3, 1.0, 2.0, 3.0}}};
      EnsembleStudy study = made.study();
      study.outputs = {"u_left@0.05"};
      study.error = 1e-3;
      const EnsembleResult found = ensemble(study), truth = truth_of(made, study.outputs);
      for (std::size_t i = 0; i < found.bars; ++i) {
        EXPECT_EQ(found.ways[i], viscosity > 0.0 ? BarWay::lanes : BarWay::alone) << mass << i;
        EXPECT_LE(error_of(found, truth, i, 1), viscosity > 0.0 ? 3.0 * found.error[i] : 1e-3)
            << mass << viscosity << i;
      }
    }
}

TEST(Ensemble, AStopLeavesTheRestNotRun) {
  TextEnsemble made{thrown, {"bar.viscosity"}, {std::vector<double>(4000, 0.1)}};
  EnsembleStudy study = made.study();
  study.outputs = {"impulse_left"};
  study.error = 1e-3;
  study.threads = 1;
  std::size_t done = 0;
  study.progress = [&](std::size_t now, std::size_t) { done = now; };
  study.stop = [&] { return done > 0; };
  const EnsembleResult found = ensemble(study);
  // The bars beside the one that is told as done are so, too.
  const auto left = static_cast<std::size_t>(std::ranges::count(found.status, BarStatus::not_run));
  EXPECT_LE(left, 4000 - done);
  EXPECT_GT(left + 16, 4000 - done);
  EXPECT_GT(done, 0u);
  EXPECT_LT(done, 4000u);
}

TEST(Ensemble, RefusesWhatMakesNoSense) {
  const TextEnsemble made{thrown, {"bar.viscosity", "left.gap"}, {{0.1, 0.2}, {0.1, 0.2, 0.3}}};
  const auto refused = [](EnsembleStudy study, std::string output) {
    study.outputs = {std::move(output)};
    try {
      ensemble(study);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused(made.study(), "final").find("left.gap: has 3 values where others have 2"), std::string::npos);
  const TextEnsemble one{thrown, {"bar.viscosity"}, {{0.1}}};
  EXPECT_NE(refused(one.study(), "u_middle@0.1").find("is not known"), std::string::npos);
  EXPECT_NE(refused(one.study(), "u_left@0").find("positive interval"), std::string::npos);
  EXPECT_NE(refused(one.study(), "gauge:2@0.1").find("outside of the bar"), std::string::npos);
  EXPECT_NE(refused(one.study(), "events:1.5").find("whole number"), std::string::npos);
  const TextEnsemble end{thrown, {"time.end"}, {{1.0}}};
  EXPECT_NE(refused(end.study(), "final").find("the same for all bars"), std::string::npos);
}

}  // namespace
