#include "viscobar/studies/compare/difference.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "studies/compare/matching.hpp"

namespace viscobar {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

// A bar at rest for 10 units of time whose left end bounces at these times, each for `rest`.
Recording bouncing(const std::vector<double>& closings, double rest = 0.0) {
  Recording recording;
  recording.mesh = {1.0, 2};
  recording.times = {0.0, 10.0};
  recording.u.assign(6, 0.0);
  recording.v.assign(6, 0.0);
  recording.reaction_left = recording.reaction_right = {0.0, 0.0};
  for (const double t : closings) {
    recording.events.push_back({t, Where::left, 0, Change::closing, -1.0});
    recording.events.push_back({t + rest, Where::left, 0, Change::opening, 1.0});
  }
  return recording;
}

TEST(MatchTimes, PairsEqualListsOneToOne) {
  const std::vector<double> times = {1.0, 2.0, 5.0};
  const auto matches = match_times(times, times, 1.0);
  ASSERT_EQ(matches.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(matches[k].first == k && matches[k].other == k);
}

TEST(MatchTimes, KeepsTheOrderAndUsesNothingTwice) {
  const std::vector<double> a = {1.0, 1.1, 1.2, 4.0}, b = {0.9, 1.15, 3.9, 4.1, 4.2};
  const auto matches = match_times(a, b, 2.0);
  for (std::size_t k = 1; k < matches.size(); ++k) {
    EXPECT_LT(matches[k - 1].first, matches[k].first);
    EXPECT_LT(matches[k - 1].other, matches[k].other);
  }
  EXPECT_EQ(matches.size(), 3u);  // 1.2 has nobody left within reach
}

TEST(MatchTimes, LeavesTimesFurtherApartThanTheReachAlone) {
  EXPECT_TRUE(match_times(std::vector{1.0}, std::vector{2.0}, 0.5).empty());
  EXPECT_TRUE(match_times({}, std::vector{2.0}, 0.5).empty());
}

TEST(Compare, AMissedBounceDoesNotShiftTheLaterOnes) {
  const Difference found =
      compare(bouncing({1, 2, 3, 4, 5, 6, 7, 8}), bouncing({1.01, 2.01, 4.01, 5.01, 6.01, 7.01, 8.01}));
  EXPECT_EQ(found.events_matched, 14u);
  EXPECT_NEAR(*found.largest_event_shift, 0.01, 10 * eps);
}

TEST(Compare, BouncesMissedOnBothSidesStayAlone) {
  const Difference found = compare(bouncing({1, 2, 3, 4, 5, 6, 7, 9}), bouncing({1, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_LE(*found.largest_event_shift, 1.0 + 10 * eps);
  EXPECT_GE(found.events_matched, 14u);
}

TEST(Compare, FollowsADriftBelowTheDistanceOfTheBounces) {
  const Difference found = compare(bouncing({1, 2, 3, 4, 5, 6}), bouncing({1.1, 2.2, 3.3, 4.4, 5.5, 6.6}));
  EXPECT_EQ(found.events_matched, 12u);
  EXPECT_NEAR(*found.largest_event_shift, 0.6, 100 * eps);
}

TEST(Compare, MatchesContactPeriodsAsItDoesEvents) {
  const Difference found = compare(bouncing({1, 3, 5, 7}, 0.5), bouncing({1, 5, 7}, 0.6));
  ASSERT_EQ(found.contacts.size(), 3u);
  for (const auto& [a, b] : found.contacts) EXPECT_EQ(a.begin, b.begin);
}

// A finished run tells the reaction at its output times, and no account of a contact between two of them.
TEST(Compare, TheImpulseOfAContactBetweenTwoTimesIsNotKnown) {
  Recording run = bouncing({1.0}, 0.5);
  EXPECT_FALSE(contact_periods(run, 0.1).at(0).impulse);
  run.times = {0.0, 1.0, 1.25, 1.5};
  run.reaction_left = {0.0, 2.0, 2.0, 2.0};
  EXPECT_DOUBLE_EQ(contact_periods(run, 0.1).at(0).impulse.value(), 1.0);
}

TEST(Compare, MatchesClosingsWithClosingsAtTheSamePlaceOnly) {
  Recording left = bouncing({1.0}), right = bouncing({1.0});
  for (Event& event : right.events) event.where = Where::right;
  EXPECT_EQ(compare(left, right).events_matched, 0u);
  Recording closing = bouncing({1.0}), opening = bouncing({1.0});
  closing.events.pop_back();
  opening.events.erase(opening.events.begin());
  EXPECT_EQ(compare(closing, opening).events_matched, 0u);
}

TEST(Compare, AllBouncesOfALongChatterFindTheirPartners) {
  std::vector<double> a, b;
  for (int k = 0; k < 3000; ++k) a.push_back(3e-3 * k + 1e-3), b.push_back(a.back() + 5e-4);
  const Difference found = compare(bouncing(a, 1e-3), bouncing(b, 1e-3));
  EXPECT_EQ(found.events_matched, 6000u);
  EXPECT_NEAR(*found.largest_event_shift, 5e-4, 20 * eps);
}

TEST(Compare, EndsAloneAreComparedWithTheEndsOfAField) {
  Recording field = bouncing({}), ends = bouncing({});
  ends.mesh.elements = 1;
  ends.u = {0.0, 0.0, 0.25, -0.125};
  ends.v.clear();
  const Difference found = compare(field, ends);
  EXPECT_EQ(found.end_trace, 0.25);
  EXPECT_FALSE(found.displacement_l2);
  EXPECT_FALSE(found.velocity_l2);
  ends.mesh.elements = 3;
  EXPECT_THROW(compare(field, ends), std::invalid_argument);
}

}  // namespace
}  // namespace viscobar
