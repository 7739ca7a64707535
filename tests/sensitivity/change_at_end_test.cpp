// A contact change at the very end of a run, or a few roundings to either side of it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "support/falling_bar.hpp"
#include "viscobar/case/recording.hpp"

namespace {

using namespace viscobar;

// u = -t comes to the obstacle at t = gap. By gap, and by the speed of the throw.
Case flight_to_an_end(MethodName method, double restitution, double gap) {
  Case run;
  run.scene = falling_bar(gap, 1.0, 0.1);
  run.elements = 10;
  run.method = method;
  run.mass = Mass::consistent;
  run.tolerance = {1e-10};
  run.epsilon = 1e-2;
  run.restitution = restitution;
  run.directions = {direction(run, "left.gap"), direction(run, "bar.density")};
  run.directions[1].bar.density = 0.0;
  run.directions[1].data.velocity = [](double) { return -1.0; };
  return run;
}

struct AtEnd {
  std::size_t changes = 0;
  std::vector<double> times;        // of the first change, by each parameter
  std::vector<double> u, accounts;  // at the end
  double impulse = 0.0;
};

AtEnd at_end(Case run, double end) {
  run.end = run.output_every = end;
  const Recording found = record(run);
  AtEnd told;
  EXPECT_FALSE(found.statistics.sensitivity->lost.has_value());
  told.changes = found.events.size();
  if (told.changes > 0)
    for (const ChangeSensitivity& by : found.events[0].sensitivities) told.times.push_back(by.time);
  for (const RecordedSensitivity& by : found.sensitivities)
    told.u.insert(told.u.end(), by.u.end() - static_cast<std::ptrdiff_t>(found.mesh.nodes()), by.u.end());
  const SensitivityAccount& account = *found.statistics.sensitivity;
  for (const auto* of : {&account.impulse_left, &account.energy})
    told.accounts.insert(told.accounts.end(), of->begin(), of->end());
  told.impulse = found.statistics.account->left.impulse;
  return told;
}

// Derivatives at the end are those of their side of the change. Their rates are below 1e4: an acceleration of an impact
// within h, over the time of flight. So 1e-10 from the change they are known to 1e-6, and a hundred tolerances are
// less.
TEST(SensitivitiesAtTheEnd, AreThoseBeforeOrAfterAChangeAndSayWhich) {
  struct Contact {
    MethodName method;
    double restitution;
  };
  for (const auto& [method, restitution] : {Contact{MethodName::rigid, 0.0},
                                            {MethodName::rigid, 0.5},
                                            {MethodName::cvode, 1.0},
                                            {MethodName::cvode, 0.5},
                                            {MethodName::ida, 0.5},
                                            {MethodName::arkode, 0.5}})
    for (const double gap : {0.5, 0.3}) {
      const Case run = flight_to_an_end(method, restitution, gap);
      Case longer = run;
      longer.end = 0.6, longer.output_every = 0.1;
      const Recording located = record(longer);
      ASSERT_GE(located.events.size(), 1u);
      const double change = located.events[0].time;
      EXPECT_NEAR(change, gap, 1e-12);
      const AtEnd before = at_end(run, change - 1e-10), after = at_end(run, change + 1e-10);
      const std::string what = fmt::format("{} {} {}", name(method), restitution, gap);
      ASSERT_EQ(before.changes, 0u) << what;
      ASSERT_GE(after.changes, 1u) << what;
      const auto expect = [](const std::vector<double>& told, const std::vector<double>& of, const std::string& where) {
        ASSERT_EQ(told.size(), of.size()) << where;
        for (std::size_t i = 0; i < told.size(); ++i)
          EXPECT_NEAR(told[i], of[i], 1e-6 * std::max(1.0, std::abs(of[i]))) << where << ", " << i;
      };
      // dt*/dgap = 1 at speed 1, dt*/dspeed = -gap; the flight itself.
      expect({after.times[0], after.times[1]}, {1.0, -gap}, what);
      for (std::size_t j = 0; j < 11; ++j) {
        EXPECT_NEAR(before.u[j], 0.0, 1e-9) << what;
        EXPECT_NEAR(before.u[11 + j], -change, 1e-9) << what;
      }
      expect(before.accounts, {0.0, 0.0, 0.0, 1.0}, what);
      bool changed = false;
      std::size_t without = 0, with = 0;
      for (const int ulps : {-300, -30, -3, -2, -1, 0, 1, 2, 3, 10, 30, 100, 300, 1000, 3000, 10000, 100000}) {
        const double end = change + ulps * (std::nextafter(change, 1.0) - change);
        const AtEnd told = at_end(run, end);
        const std::string where = fmt::format("{}, {} roundings", what, ulps);
        const bool is_told = told.changes > 0;
        // On a leg of so many roundings a contact may open again: that is told, and the derivatives are of the flight.
        const bool is_after = is_told && told.changes % 2 == after.changes % 2;
        EXPECT_FALSE(is_told && ulps < 0) << where;
        EXPECT_TRUE(is_told || !changed) << where << ": once it is seen, a later end sees it, too";
        changed = is_told;
        (is_after ? with : without) += 1;
        expect(told.u, is_after ? after.u : before.u, where);
        expect(told.accounts, is_after ? after.accounts : before.accounts, where);
        expect({told.impulse}, {is_after ? after.impulse : before.impulse}, where);
        if (is_told) expect(told.times, after.times, where);
      }
      EXPECT_GE(without, 3u) << what;
      EXPECT_GE(with, 1u) << what;
    }
}

}  // namespace
