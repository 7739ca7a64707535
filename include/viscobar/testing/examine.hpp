#pragma once

// The one header of the library that needs GoogleTest: examinations and orders as assertions of a test.

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "viscobar/report/reports.hpp"

namespace viscobar {

/// EXPECT_TRUE(passes("mine", my_scheme, trial)): within the trial's bounds; a failure prints the tables.
inline ::testing::AssertionResult passes(const std::string& label, const Solver& scheme, const Trial& trial) {
  const TrialResult result = examine(label, scheme, {&trial, 1}).front();
  if (result.passed()) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "\n" << trial_text(result);
}

/// EXPECT_TRUE(has_order(study.end_trace, 2.0, 0.1))
inline ::testing::AssertionResult has_order(const std::optional<ObservedOrder>& found, double order, double tolerance) {
  if (!found) return ::testing::AssertionFailure() << "no order was observed";
  if (std::abs(found->order - order) <= tolerance) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "observed order " << found->order << " +- " << found->standard_error
                                       << ", not " << order << " +- " << tolerance;
}

}  // namespace viscobar
