// Fits: what they find, and what they say of what they cannot.
#include "viscobar/studies/fit/fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "viscobar/case/recording.hpp"

namespace {

using namespace viscobar;

Case bar(std::span<const double> values, const std::vector<const char*>& keys) {
  Case run;
  run.scene.left = Obstacle{0.1};
  run.scene.bar.viscosity = 0.08;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const std::string key = keys[k];
    if (key == "bar.viscosity") run.scene.bar.viscosity = values[k];
    if (key == "bar.modulus") run.scene.bar.modulus = values[k];
    if (key == "bar.density") run.scene.bar.density = values[k];
    if (key == "left.gap") run.scene.left = Obstacle{values[k]};
  }
  run.scene.displacement = [](double) { return 0.0; };
  run.scene.velocity = [](double) { return -1.0; };
  run.elements = 20;
  run.method = MethodName::rigid;
  run.end = 4.0;
  run.output_every = 0.02;
  for (const char* key : keys) run.directions.push_back(direction(run, key));
  return run;
}

FitStudy study_of(const std::vector<const char*>& keys, const std::vector<double>& truth,
                  const std::vector<double>& start, double noise) {
  FitStudy study;
  study.model = [keys](std::span<const double> values) { return bar(values, keys); };
  const Recording made = record(bar(truth, keys));
  study.times = made.times;
  MeasuredTrace trace;
  trace.deviation = std::max(noise, 1e-3);
  std::mt19937 random(5);
  std::normal_distribution<double> error(0.0, 1.0);
  for (std::size_t k = 0; k < made.times.size(); ++k)
    trace.values.push_back(made.displacement(k).front() + noise * error(random));
  study.traces.push_back(trace);
  study.changes = made.events;
  for (std::size_t k = 0; k < keys.size(); ++k) study.parameters.push_back({keys[k], start[k], 1e-6, 1e6});
  return study;
}

TEST(Fit, FindsWhatMadeTheTrace) {
  FitStudy study = study_of({"bar.viscosity", "left.gap", "bar.modulus"}, {0.08, 0.1, 1.0}, {0.2, 0.15, 1.4}, 0.0);
  study.changes.clear();
  const FitResult found = fit(study);
  EXPECT_TRUE(found.converged) << found.reason;
  // The run's own error, and that of ending where the data tell no more.
  EXPECT_NEAR(found.parameters[0].estimate, 0.08, 1e-4);
  EXPECT_NEAR(found.parameters[1].estimate, 0.1, 1e-4);
  EXPECT_NEAR(found.parameters[2].estimate, 1.0, 1e-4);
  EXPECT_TRUE(found.undetermined.empty());
  EXPECT_LE(found.runs, 15u);
}

TEST(Fit, FindsWhatMadeTheContactTimesAlone) {
  FitStudy study = study_of({"left.gap", "bar.modulus"}, {0.1, 1.0}, {0.2, 1.3}, 0.0);
  study.traces.clear();
  study.times.clear();
  study.change_deviation = 1e-4;
  const FitResult found = fit(study);
  EXPECT_NEAR(found.parameters[0].estimate, 0.1, 1e-5);
  EXPECT_NEAR(found.parameters[1].estimate, 1.0, 1e-4);
}

TEST(Fit, KeepsWithinBoundsAndSaysSo) {
  FitStudy study = study_of({"bar.viscosity", "left.gap"}, {0.08, 0.1}, {0.2, 0.13}, 1e-3);
  study.parameters[1].low = 0.12;
  const FitResult found = fit(study);
  EXPECT_EQ(found.parameters[1].estimate, 0.12);
  EXPECT_TRUE(found.parameters[1].at_bound);
  EXPECT_TRUE(std::isnan(found.parameters[1].standard_deviation));
}

// Displacements without a load have only the ratios of modulus, viscosity and density.
TEST(Fit, SaysWhatTheDataDoNotDetermine) {
  FitStudy study = study_of({"bar.viscosity", "bar.modulus", "bar.density"}, {0.08, 1.0, 1.0}, {0.08, 1.0, 1.0}, 1e-3);
  const FitResult found = fit(study);
  ASSERT_EQ(found.undetermined.size(), 1u);
  for (const double share : found.undetermined[0].shares) EXPECT_NEAR(std::abs(share), std::sqrt(1.0 / 3.0), 1e-3);
  for (const Estimate& one : found.parameters) EXPECT_TRUE(std::isnan(one.standard_deviation));
}

TEST(Fit, ComesThroughRunsWithoutTheContactThatTheDataHave) {
  // At the start the bar, slowed by nothing, does not reach the obstacle within the data.
  FitStudy study = study_of({"left.gap", "bar.viscosity"}, {0.1, 0.08}, {5.0, 0.08}, 1e-3);
  study.change_deviation = 1e-3;
  const FitResult one = fit(study);
  study.parameters[0].low = 0.01, study.parameters[0].high = 5.0;
  study.parameters[1].low = 0.01, study.parameters[1].high = 1.0;
  study.starts = 6;
  const FitResult best = fit(study);
  EXPECT_TRUE(best.converged) << best.reason;
  EXPECT_NEAR(best.parameters[0].estimate, 0.1, 5.0 * best.parameters[0].standard_deviation);
  EXPECT_EQ(best.sums.size(), 6u);
  EXPECT_LE(best.residual, one.residual * 1.001);
}

TEST(Fit, RefusesStudiesThatMakeNoSense) {
  const FitStudy sound = study_of({"left.gap"}, {0.1}, {0.2}, 0.0);
  FitStudy study = sound;
  study.parameters.clear();
  EXPECT_THROW(fit(study), std::invalid_argument);
  study = sound;
  study.traces[0].deviation = 0.0;
  EXPECT_THROW(fit(study), std::invalid_argument);
  study = sound;
  study.starts = 3, study.parameters[0].high = INFINITY;
  EXPECT_THROW(fit(study), std::invalid_argument);
  study = sound;
  study.parameters[0].start = -1.0;
  EXPECT_THROW(fit(study), std::invalid_argument);
}

}  // namespace
