#include "viscobar/studies/precision/precision.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "support/absolute_tolerance.hpp"
#include "support/paper_throw.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"

namespace viscobar {
namespace {

/// Contact that closes and opens twice, of a bar with viscosity 1/2, known exactly.
PrecisionStudy manufactured() {
  const exact::ManufacturedContact contact;
  PrecisionStudy study;
  study.scene.scene = contact.scene();
  study.scene.elements = 16;
  study.scene.mass = Mass::redistributed;
  study.scene.epsilon = 1e-6;
  study.scene.end = 1.9;
  study.scene.output_every = 0.02;
  study.tolerances = {1e-4, 1e-6, 1e-8};
  study.halvings = 6;
  study.repeat = 3;
  study.seconds = 60.0;  // a busy machine leaves nothing out
  study.exact = KnownSolution{"manufactured contact", [contact](double x, double t) { return contact.u(x, t); }};
  return study;
}

/// The paper's second reading, symmetric contact at both ends: no closed form.
PrecisionStudy two_ends() {
  PrecisionStudy study;
  study.scene.scene = paper_throw(1.0).scene;
  study.scene.mass = Mass::consistent;
  study.scene.end = 3.0;
  study.scene.output_every = 0.02;
  study.elements = {16, 32, 64};
  study.methods = {MethodName::fully_discrete};
  study.halvings = 6;
  study.seconds = 60.0;
  return study;
}

const ErrorParts& parts_of(const PrecisionResult& result, MethodName method, std::size_t elements) {
  for (const ErrorParts& parts : result.parts)
    if (parts.method == method && parts.elements == elements) return parts;
  throw std::logic_error("no such method or mesh");
}

/// Both orders of the space part over three meshes, each the half of the one before, within 0.1 of linear elements' 2.
void expect_second_order(const PrecisionStudy& study, MethodName method) {
  const PrecisionResult result = precision_of(study);
  const auto space = [&](std::size_t mesh) { return *parts_of(result, method, study.elements[mesh]).space; };
  EXPECT_NEAR(std::log2(space(0) / space(1)), 2.0, 0.1);
  EXPECT_NEAR(std::log2(space(1) / space(2)), 2.0, 0.1);
}

// On the consistent mass this solution, a polynomial of degree 2 in x, would have no space error at all. What moving
// the mass off the end costs is C h^2 (1 - O(h)): the order comes to 2 from below.
TEST(Precision, SpaceFallsWithTheSquareOfTheElementOnMasslessContactNodes) {
  PrecisionStudy study = manufactured();
  study.elements = {64, 128, 256};
  study.methods = {MethodName::rigid};
  study.tolerances = {1e-6};
  expect_second_order(study, MethodName::rigid);
}

TEST(Precision, SpaceFallsWithTheSquareOfTheElementOnTheConsistentMass) {
  const PrecisionStudy study = two_ends();
  expect_second_order(study, MethodName::fully_discrete);
  // The reference is on the fourth-order mass.
  const auto levels = precision_of(study).reference->levels;
  EXPECT_NEAR(std::log2(*levels[0].difference / *levels[1].difference), 4.0, 0.15);
}

// A mass rebounds on every mesh: errors are against that motion, and fall.
TEST(Precision, OfAMassThatReboundsIsAgainstOneThatDoes) {
  PrecisionStudy study;
  study.scene.scene = paper_throw(1.0).scene;
  study.scene.scene.left_input.mass = 0.5;
  study.scene.restitution = 0.8;
  study.scene.end = 3.0;
  study.elements = {16, 64};
  study.methods = {MethodName::rigid};
  study.tolerances = {1e-6};
  study.repeat = 1;
  study.seconds = 60.0;
  const PrecisionResult result = precision_of(study);
  EXPECT_LT(*result.rows[1].error, 0.5 * *result.rows[0].error);
}

// Massless contact nodes: below h^3 / eta^2 / 100 the penetration is epsilon R, and so is all that comes of it.
TEST(Precision, PenaltyIsLinearInEpsilonOnMasslessContactNodes) {
  PrecisionStudy study = manufactured();
  study.methods = {MethodName::cvode};
  const auto penalty = [&](double epsilon) {
    study.scene.epsilon = epsilon;
    const PrecisionResult result = precision_of(study);
    const ErrorParts& parts = result.parts.at(0);
    EXPECT_NEAR(*parts.penalty_order, 1.0, 0.03);
    EXPECT_NE(parts.penalty_against.find("rigid"), std::string::npos);
    return *parts.penalty;
  };
  EXPECT_NEAR(std::log10(penalty(1e-5) / penalty(1e-6)), 1.0, 0.03);
}

// Consistent mass, restitution 0 on the penalty: epsilon / 100 stands for the limit. The contact closes at velocity 0,
// so that nothing bounces: here, too, the penetration is epsilon R, and the largest reaction is 1, to h^2 = 0.4 % a few
// times.
TEST(Precision, PenaltyOnNodesWithMassIsMeasuredAgainstASmallerEpsilon) {
  PrecisionStudy study = manufactured();
  study.scene.mass = Mass::consistent;
  study.scene.restitution = 0.0;
  study.methods = {MethodName::cvode};
  const PrecisionResult result = precision_of(study);
  const ErrorParts& parts = result.parts.at(0);
  EXPECT_NE(parts.penalty_against.find("epsilon / 100"), std::string::npos);
  EXPECT_NEAR(*parts.penalty / *study.scene.epsilon, 1.0, 0.03);
  EXPECT_NEAR(*parts.penalty_order, 1.0, 0.03);
}

// `redistributed` leaves a mass on an end its own; its rebound counts as space.
TEST(Precision, PenaltyUnderAMassOnAnEndIsMeasuredAgainstASmallerEpsilonToo) {
  PrecisionStudy study;
  study.scene =
      parse_scene(
          "[bar]\nlength = 1.0\nviscosity = 0.06\n[left]\nkind = \"obstacle\"\ngap = 0.2\nside = \"above\"\n"
          "[right]\nkind = \"obstacle\"\ngap = 0.06\nmass = 0.4\nstiffness = 7.0\n[initial]\nvelocity = -1.2\n"
          "[time]\nend = 2.0\n[mesh]\nelements = 4\nmass = \"redistributed\"\n[contact]\nepsilon = 1e-6\n",
          "")
          .run;
  study.methods = {MethodName::arkode};
  study.tolerances = {1e-7};
  study.seconds = 60.0;
  const ErrorParts parts = parts_of(precision_of(study), MethodName::arkode, 4);
  ASSERT_TRUE(parts.penalty && parts.space);
  EXPECT_LT(*parts.penalty, 0.05 * *parts.space);
}

// Two ways to one semi-discrete solution: epsilon to 0 by matrix exponentials, dt to 0 by the scheme.
TEST(Precision, PenaltyAndSchemeOfOneLawOfImpactLeaveTheSameSpace) {
  PrecisionStudy study = two_ends();
  study.elements = {16};
  study.methods = {MethodName::cvode, MethodName::fully_discrete};
  study.tolerances = {1e-6};
  study.scene.epsilon = 1e-4;
  study.scene.restitution = 0.0;
  const PrecisionResult result = precision_of(study);
  const double penalised = *parts_of(result, MethodName::cvode, 16).space;
  const double scheme = *parts_of(result, MethodName::fully_discrete, 16).space;
  // The error by epsilon / 100 remains, less the part that extrapolation removes.
  EXPECT_NEAR(penalised, scheme, 0.01 * *parts_of(result, MethodName::cvode, 16).penalty);
}

// There is no penalty then, and no limit of one.
TEST(Precision, OfStopsWithLawsIsAgainstTheBarThatHasThem) {
  PrecisionStudy study = two_ends();
  study.scene.scene.left_input.stop = study.scene.scene.right_input.stop = Stop{Law::spring_damper, 50.0, 1.0};
  study.scene.mass = Mass::fourth_order;
  study.scene.epsilon.reset();
  study.elements = {16, 32};
  study.methods = {MethodName::arkode};
  study.tolerances = {1e-8};
  const PrecisionResult result = precision_of(study);
  ASSERT_TRUE(result.reference);
  EXPECT_NE(result.reference->what.find("arkode"), std::string::npos);
  const ErrorParts &coarse = parts_of(result, MethodName::arkode, 16), &fine = parts_of(result, MethodName::arkode, 32);
  EXPECT_FALSE(coarse.penalty);
  EXPECT_FALSE(coarse.epsilon);
  EXPECT_NEAR(std::log2(*coarse.space / *fine.space), 4.0, 0.7);  // of the mass, on meshes this coarse
}

TEST(Precision, TimeFollowsTheToleranceAndTheStep) {
  const PrecisionStudy study = manufactured();
  const PrecisionResult result = precision_of(study);
  const double size = result.reference->largest_displacement;
  for (const PrecisionRow& row : result.rows) {
    ASSERT_TRUE(row.time_error) << name(row.method) << " " << row.label;
    if (!is_adaptive(row.method)) continue;
    // Promise of docs/methods.md for a tolerance.
    const double absolute = absolute_tolerance(study.scene) * row.setting / study.scene.tolerance.relative;
    EXPECT_LE(*row.time_error, 100.0 * (row.setting * size + absolute)) << name(row.method) << " " << row.label;
  }
  const auto error_at = [&](MethodName method, std::size_t k) {
    for (const PrecisionRow& row : result.rows)
      if (row.method == method && k-- == 0) return *row.time_error;
    throw std::logic_error("no such row");
  };
  // Four decades of tolerance; half of the digits that they should give is the least.
  for (const MethodName method : {MethodName::cvode, MethodName::ida, MethodName::rigid})
    EXPECT_LT(error_at(method, 2), 1e-2 * error_at(method, 0)) << name(method);
  // First order over three halvings of the step.
  EXPECT_GT(error_at(MethodName::fully_discrete, 3) / error_at(MethodName::fully_discrete, 6), 6.0);
}

TEST(Precision, PartsBoundTheErrorFromAboveAndFromBelow) {
  PrecisionStudy study = manufactured();
  study.scene.epsilon = 1e-3;
  const PrecisionResult result = precision_of(study);
  for (const PrecisionRow& row : result.rows) {
    const ErrorParts& parts = result.parts_of(row);
    const double penalty = parts.penalty.value_or(0.0), sum = *parts.space + penalty + *row.time_error;
    const double largest = std::max({*parts.space, penalty, *row.time_error});
    const double rounding = 100 * std::numeric_limits<double>::epsilon();
    EXPECT_LE(*row.error, sum + rounding) << row.label;
    EXPECT_GE(*row.error, 2 * largest - sum - rounding) << row.label;
  }
}

TEST(Precision, AFinerRunIsAsGoodAsItSays) {
  PrecisionStudy study = manufactured();
  study.methods = {MethodName::rigid, MethodName::fully_discrete};
  const PrecisionResult exact = precision_of(study);
  study.exact.reset();
  const PrecisionResult finer = precision_of(study);
  EXPECT_TRUE(exact.reference->closed_form);
  EXPECT_EQ(exact.reference->error, 0.0);
  EXPECT_FALSE(finer.reference->closed_form);
  EXPECT_NE(finer.reference->what.find("rigid on"), std::string::npos) << finer.reference->what;
  EXPECT_GE(finer.reference->levels.size(), 4u);
  ASSERT_EQ(exact.rows.size(), finer.rows.size());
  // The estimate takes the difference of two meshes for that of all finer ones: right to the digit that it is given to.
  for (std::size_t i = 0; i < exact.rows.size(); ++i)
    EXPECT_NEAR(*finer.rows[i].error, *exact.rows[i].error, 1.5 * finer.reference->error) << exact.rows[i].label;
}

// From 16 to 1024 elements the differences double.
TEST(Precision, MeshesThatRunAwayFromEachOtherAreNoReference) {
  PrecisionStudy study;
  study.scene = parse_scene(
                    "[bar]\nlength=1\nviscosity=0.0036\n[span]\ngap=0.1\n[initial]\n"
                    "velocity=\"-1.2*(1+0.3*x)\"\n[time]\nend=0.4\n[mesh]\nelements=16\n"
                    "[contact]\nrestitution=0.16\n[output]\nevery=0.05\n",
                    "scene", {})
                    .run;
  study.methods = {MethodName::fully_discrete};
  study.halvings = 0;
  study.repeat = 3;
  study.seconds = 60.0;
  const PrecisionResult result = precision_of(study);
  EXPECT_FALSE(result.reference->settles);
  EXPECT_GE(result.reference->error, result.reference->largest_displacement);
  study.scene.restitution = 0.0;
  EXPECT_TRUE(precision_of(study).reference->settles);
}

TEST(Precision, TimeReferencesAreCheckedBySomethingElse) {
  const PrecisionResult result = precision_of(manufactured());
  for (const ErrorParts& parts : result.parts) {
    EXPECT_FALSE(parts.time_reference.empty()) << name(parts.method);
    EXPECT_GT(parts.time_reference_error, 0.0) << name(parts.method);
  }
  EXPECT_NE(parts_of(result, MethodName::cvode, 16).time_reference.find("exponential, checked by cvode"),
            std::string::npos);
}

TEST(Precision, EveryRowIsAMedianOfAnOddNumberOfRuns) {
  PrecisionStudy study = manufactured();
  study.repeat = 0;
  for (const PrecisionRow& row : precision_of(study).rows) {
    EXPECT_GE(row.runs, 3u);
    EXPECT_EQ(row.runs % 2, 1u);
    EXPECT_GT(row.seconds, 0.0);
    EXPECT_GT(row.steps, 0u);
  }
}

TEST(Precision, ARunThatFailsIsARowThatSaysSo) {
  PrecisionStudy study = manufactured();
  study.methods = {MethodName::cvode, MethodName::fully_discrete};
  study.exact.reset();
  study.scene.scene.load =
      GeneralLoad{[](double, double t) { return t > 0.5 ? std::numeric_limits<double>::quiet_NaN() : 0.0; }};
  const PrecisionResult result = precision_of(study);
  ASSERT_EQ(result.rows.size(), 3u + 7u);
  for (const PrecisionRow& row : result.rows) {
    EXPECT_NE(row.failure.find("load"), std::string::npos) << row.failure;
    EXPECT_FALSE(row.error || row.time_error);
  }
  EXPECT_FALSE(result.reference);
  EXPECT_FALSE(result.no_reference.empty());
}

TEST(Precision, WhatTakesTooLongIsLeftOutAloud) {
  PrecisionStudy study = manufactured();
  study.methods = {MethodName::fully_discrete};
  study.halvings = 30;
  study.seconds = 0.05;
  const PrecisionResult result = precision_of(study);
  EXPECT_LT(result.rows.size(), 31u);
  ASSERT_EQ(result.left_out.size(), 1u);
  EXPECT_NE(result.left_out[0].reason.find("0.05 s"), std::string::npos);
  EXPECT_NE(result.left_out[0].what.find("step"), std::string::npos);
}

TEST(Precision, MethodsThatDoNotFitAreLeftOutOrRefusedWhenAskedFor) {
  PrecisionStudy study = manufactured();
  study.tolerances = {1e-4};
  study.halvings = 3;
  const PrecisionResult result = precision_of(study);
  ASSERT_EQ(result.left_out.size(), 1u);
  EXPECT_EQ(result.left_out[0].method, MethodName::finite_difference) << "its mass is diagonal";
  study.methods = {MethodName::finite_difference};
  EXPECT_THROW(precision_of(study), std::invalid_argument);
}

}  // namespace
}  // namespace viscobar
