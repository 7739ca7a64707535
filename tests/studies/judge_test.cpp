#include "viscobar/studies/judge/judge.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "dynamics/gauge.hpp"
#include "support/falling_bar.hpp"
#include "viscobar/case/recording.hpp"

namespace viscobar::testing_judge {
namespace {

// A bar thrown at an obstacle, which it leaves again.
Case thrown() {
  Case run;
  run.scene = falling_bar(0.1, 1.0, 0.1);
  run.end = 4.0;
  run.output_every = 0.02;
  run.automatic = true;
  run.method = MethodName::rigid;
  return run;
}

JudgeStudy study_of(std::vector<TheirSolution> solutions) {
  JudgeStudy study;
  study.scene = thrown();
  study.request.error = 1e-3;
  study.request.relative = true;
  study.solutions = std::move(solutions);
  return study;
}

// By the scheme of the paper, as somebody else's program would write it.
TheirSolution by_scheme(double step) {
  Case run = thrown();
  run.automatic = false;
  run.method = MethodName::fully_discrete;
  run.elements = 160;
  run.mass = Mass::fourth_order;
  run.step = step;
  const Recording made = record(run);
  TheirSolution theirs{"scheme", made.times, {}, step};
  std::vector<double> left, middle;
  const Gauge gauge(run.mesh(), run.scene.bar, 0.3);
  for (std::size_t k = 0; k < made.times.size(); ++k) {
    left.push_back(made.displacement(k).front());
    middle.push_back(gauge(made.displacement(k), made.velocity(k)).u);
  }
  theirs.columns = {{"u_left", left}, {"u@0.3", middle}, {"reaction_left", made.reaction_left}};
  return theirs;
}

// The bar on a mesh so fine that its own error, (1/640)^4 of order 4, is none beside that of a scheme.
Recording fine_run(std::size_t elements) {
  Case fine = thrown();
  fine.elements = elements;
  fine.mass = Mass::fourth_order;
  fine.tolerance.relative = 1e-11;
  return record(fine);
}

// The same distance as to that run, within our own error. The touch at t = 0.1 ends a step of each: the scheme has its
// second order, and two steps 2 : 1 show it to the terms of the next, a tenth.
TEST(Judge, TellsDistancesAndOrderOfAScheme) {
  const JudgeResult judgement = judge(study_of({by_scheme(0.02), by_scheme(0.01), by_scheme(0.005)}));
  const Recording truth = fine_run(640);
  ASSERT_EQ(judgement.solutions.size(), 3u);
  for (std::size_t s = 0; s < 3; ++s) {
    const JudgedColumn& left = judgement.solutions[s].columns[0];
    double largest = 0.0;
    for (std::size_t k = 0; k < truth.times.size(); ++k)
      largest = std::max(largest, std::abs(left.theirs[k] - truth.displacement(k).front()));
    EXPECT_NEAR(left.largest, largest, *left.own_error);
    EXPECT_TRUE(left.told_apart());
    EXPECT_LE(*left.own_error, 0.1 * left.largest);
    EXPECT_EQ(judgement.solutions[s].count(ContactVerdict::missed), 0u);
    EXPECT_EQ(judgement.solutions[s].count(ContactVerdict::made_up), 0u);
    ASSERT_EQ(judgement.solutions[s].contacts.size(), 1u);
    const JudgedContact& contact = judgement.solutions[s].contacts[0];
    const double late = 0.02 + 0.5 * std::array{0.02, 0.01, 0.005}[s];  // a sample, and half a step of the scheme
    EXPECT_NEAR(*contact.their_begin, *contact.begin, late);
    EXPECT_NEAR(*contact.their_end, *contact.end, late);
  }
  for (const std::size_t s : {std::size_t{1}, std::size_t{2}})
    for (const std::size_t column : {std::size_t{0}, std::size_t{1}})
      EXPECT_NEAR(judgement.solutions[s].columns[column].order.value(), 2.0, 0.1) << s << column;
}

TEST(Judge, TellsContactsThatAreMissedOrMadeUp) {
  TheirSolution blind = by_scheme(0.01), seeing = blind;
  for (double& reaction : blind.columns[2].values) reaction = 0.0;
  blind.columns.erase(blind.columns.begin());
  seeing.columns[2].values[seeing.times.size() - 20] = 0.7;
  const JudgeResult judgement = judge(study_of({blind, seeing}));
  EXPECT_EQ(judgement.solutions[0].count(ContactVerdict::missed), 1u);
  EXPECT_EQ(judgement.solutions[0].count(ContactVerdict::made_up), 0u);
  EXPECT_EQ(judgement.solutions[1].count(ContactVerdict::missed), 0u);
  EXPECT_EQ(judgement.solutions[1].count(ContactVerdict::made_up), 1u);
}

// The force on a viscous bar that touches at t = 0 has no limit there, and would be all of our own error. A row without
// a value is the same as none, to the last bit, for both are held against the same motion of ours.
TEST(Judge, LeavesOutRowsWithoutAValueForOurOwnErrorToo) {
  const TheirSolution whole{"whole", {0.0, 0.2, 0.4, 0.6}, {{"reaction_left", {1.0, 1.1, 1.0, 1.0}}}, {}};
  TheirSolution blank = whole, without = whole;
  blank.columns[0].values[0] = std::numeric_limits<double>::quiet_NaN();
  without.times.erase(without.times.begin());
  without.columns[0].values.erase(without.columns[0].values.begin());
  JudgeStudy study = study_of({whole, blank, without});
  study.scene.scene.left = Obstacle{0.0};
  const JudgeResult judgement = judge(study);
  const JudgedColumn &all = judgement.solutions[0].columns[0], &one = judgement.solutions[1].columns[0],
                     &other = judgement.solutions[2].columns[0];
  EXPECT_GT(all.own_error.value(), one.own_error.value());
  EXPECT_EQ(one.own_error.value(), other.own_error.value());
  EXPECT_GT(all.size, one.size);
  EXPECT_EQ(one.size, other.size);
  EXPECT_EQ(one.largest, other.largest);
  EXPECT_EQ(one.root_mean_square, other.root_mean_square);
}

// The bar itself: theirs is as far from ours as its own error and ours make it.
// It begins as V sqrt(rho eta / (pi t)): a finer mesh has a larger first sample, which is no distance of theirs. The
// motion of that end is given, and no error of ours there is worth a finer run.
TEST(Judge, LeavesOutTheForceThatStopsTheEndOfAViscousBarAtTheStart) {
  JudgeStudy study = study_of({});
  study.scene.scene.right = Fixed{};
  Case scheme = study.scene;
  scheme.automatic = false;
  scheme.method = MethodName::fully_discrete;
  scheme.elements = 160;
  scheme.step = 0.01;
  const Recording made = record(scheme);
  std::vector<double> left, right;
  for (std::size_t k = 0; k < made.times.size(); ++k)
    left.push_back(made.displacement(k).front()), right.push_back(made.displacement(k).back());
  study.solutions = {
      {"scheme", made.times, {{"u_left", left}, {"u_right", right}, {"reaction_right", made.reaction_right}}, {}}};
  const JudgeResult judgement = judge(study);
  const JudgedColumn& force = judgement.solutions[0].columns[2];
  EXPECT_LT(*force.own_mean, 1e-3);
  EXPECT_LT(force.mean, 0.1);
  EXPECT_LT(judgement.run.elements, 2000u);
}

TEST(Judge, DoesNotBlameTheBarItself) {
  const Recording truth = fine_run(400), coarser = fine_run(200);
  Case fine = thrown();
  fine.elements = 400;
  double of_theirs = 0.0;  // at most the difference to half as many elements
  for (std::size_t k = 0; k < truth.times.size(); ++k)
    of_theirs = std::max(of_theirs, std::abs(truth.displacement(k).front() - coarser.displacement(k).front()));
  TheirSolution theirs{"the bar", truth.times, {}, {}};
  std::vector<double> left, u_middle, v_left, v_middle, right, v_right;
  const Gauge gauge(fine.mesh(), fine.scene.bar, 0.5);
  for (std::size_t k = 0; k < truth.times.size(); ++k) {
    const Gauge::Reading reading = gauge(truth.displacement(k), truth.velocity(k));
    left.push_back(truth.displacement(k).front()), v_left.push_back(truth.velocity(k).front());
    right.push_back(truth.displacement(k).back()), v_right.push_back(truth.velocity(k).back());
    u_middle.push_back(reading.u), v_middle.push_back(reading.v);
  }
  theirs.columns = {{"u_left", left},     {"v_left", v_left},  {"u_right", right},
                    {"v_right", v_right}, {"u@0.5", u_middle}, {"v@0.5", v_middle}};
  const JudgeResult judgement = judge(study_of({theirs}));
  const JudgedSolution& judged = judgement.solutions[0];
  for (const std::size_t u : {std::size_t{0}, std::size_t{4}})
    EXPECT_LE(judged.columns[u].largest, *judged.columns[u].own_error + of_theirs) << judged.columns[u].name;
  ASSERT_TRUE(judged.energy_share);
  // Energies are squares: twice the relative difference of velocities, the largest of which is 1, and of strains.
  double of_v = 0.0;
  for (const std::size_t v : {std::size_t{1}, std::size_t{3}, std::size_t{5}})
    of_v = std::max(of_v, judged.columns[v].largest);
  EXPECT_LE(std::abs(*judged.energy_share), 4.0 * of_v);
}

TEST(Judge, SaysWhatIsWrongWithASolution) {
  const auto refused = [](TheirSolution theirs) {
    try {
      judge(study_of({std::move(theirs)}));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::vector<double> two = {0.0, 1.0};
  EXPECT_NE(refused({"a", {0.0, 5.0}, {{"u_left", two}}, {}}).find("the scene ends at 4"), std::string::npos);
  EXPECT_NE(refused({"a", two, {{"w_left", two}}, {}}).find("w_left: no column"), std::string::npos);
  EXPECT_NE(refused({"a", two, {{"u@1.5", two}}, {}}).find("no place of the bar"), std::string::npos);
  EXPECT_NE(refused({"a", {1.0, 1.0}, {{"u_left", two}}, {}}).find("twice"), std::string::npos);
  EXPECT_NE(refused({"a", two, {}, {}}).find("no column"), std::string::npos);
}

// A short elastic bar, thrown at an obstacle: in contact from 0.1 to 0.3 with u = -0.1 and R = 1 there (R = rho c v for
// the time 2 L / c), then it flies off as it came.
JudgeStudy bouncing(std::vector<TheirSolution> solutions) {
  JudgeStudy study = study_of(std::move(solutions));
  study.scene.scene.bar = {0.1, 1.0, 1.0, 0.0};
  study.scene.method = MethodName::characteristics;
  study.scene.end = 1.0;
  return study;
}

double u_of_bouncing(double t) { return t < 0.1 ? -t : t < 0.3 ? -0.1 : t - 0.4; }

// The same bar, by a scheme that is late.
TheirSolution late_by(double delay, std::size_t samples = 1000) {
  TheirSolution theirs{"late", {}, {{"u_left", {}}, {"reaction_left", {}}}, {}};
  for (std::size_t k = 0; k < samples; ++k) {
    const double t = (static_cast<double>(k) + 0.5) / static_cast<double>(samples), at = t - delay;
    theirs.times.push_back(t);
    theirs.columns[0].values.push_back(u_of_bouncing(at));
    theirs.columns[1].values.push_back(at > 0.1 && at < 0.3 ? 1.0 : 0.0);
  }
  return theirs;
}

// Between the nodes of ours a gauge is off by O(h) of u and O(1) of v where a kink passes.
TEST(Judge, KnowsWhatGaugesOfAnElasticBarAreOffBy) {
  constexpr double x = 0.0333;
  TheirSolution exact{"exact", {}, {{"u@0.0333", {}}, {"v@0.0333", {}}, {"strain@0.0333", {}}}, {}};
  for (std::size_t k = 0; k < 400; ++k) {
    const double t = (static_cast<double>(k) + 0.5) / 400.0, stops = 0.1 + x, leaves = 0.3 - x;
    exact.times.push_back(t);
    exact.columns[0].values.push_back(std::max(t - leaves, 0.0) - std::min(t, stops));
    exact.columns[1].values.push_back(t < stops ? -1.0 : t < leaves ? 0.0 : 1.0);
    exact.columns[2].values.push_back(t < stops || t > leaves ? 0.0 : -1.0);
  }
  const JudgeResult judgement = judge(bouncing({exact}));
  for (const JudgedColumn& column : judgement.solutions[0].columns) {
    EXPECT_FALSE(column.told_apart()) << column.name << " " << column.distance() << " " << *column.own_distance();
    EXPECT_LT(column.distance(), 0.01) << column.name;
  }
}

TEST(Judge, ALateContactIsOneContact) {
  const JudgeResult judgement = judge(bouncing({late_by(0.4), late_by(-0.05)}));
  for (std::size_t s = 0; s < 2; ++s) {
    const std::vector<JudgedContact>& contacts = judgement.solutions[s].contacts;
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_EQ(contacts[0].verdict, ContactVerdict::found);
    EXPECT_NEAR(contacts[0].begin.value(), 0.1, 1e-12);
    EXPECT_NEAR(contacts[0].delay().value(), s == 0 ? 0.4 : -0.05, 0.001);
    EXPECT_NEAR(contacts[0].longer().value(), 0.0, 0.002);
  }
}

// R of a scheme that is late by one step differs by 1 for twice that step: a mean of order 1, a largest of order 0.
// A solution of another scheme is no coarser solution of this one.
TEST(Judge, TellsTheOrderOfWhatJumpsByItsMeanAndOfEachSchemeAlone) {
  std::vector<TheirSolution> solutions = {late_by(0.04), late_by(0.02), late_by(0.01)};
  for (std::size_t s = 0; s < 3; ++s) solutions[s].step = std::array{0.04, 0.02, 0.01}[s];
  solutions.push_back(late_by(0.005));
  solutions.back().step = 0.005;
  solutions.back().scheme = 1;
  const JudgeResult judgement = judge(bouncing(solutions));
  for (const std::size_t s : {std::size_t{1}, std::size_t{2}}) {
    const JudgedColumn& reaction = judgement.solutions[s].columns[1];
    EXPECT_NEAR(reaction.largest, 1.0, 1e-12);
    EXPECT_NEAR(reaction.mean, 2.0 * *solutions[s].step / 0.999, 1e-9);  // between the first sample and the last
    EXPECT_NEAR(reaction.order.value(), 1.0, 1e-6);
    EXPECT_NEAR(judgement.solutions[s].columns[0].order.value(), 1.0, 1e-6);
  }
  EXPECT_FALSE(judgement.solutions[3].columns[0].order);
}

// Eight samples lie in the contact. Chatter may hide between them, while the end stays near the obstacle: at a speed of
// 1 it moves 0.025 from one to the next.
TEST(Judge, SaysWhereSamplesCannotTell) {
  TheirSolution chatters = late_by(0.0, 40), passes = chatters, blind = late_by(0.0, 200), parted = late_by(0.0);
  for (TheirSolution* one : {&chatters, &passes, &blind})
    for (double& reaction : one->columns[1].values) reaction = 0.0;
  for (double& u : passes.columns[0].values) u += 0.05;
  for (std::size_t k = 150; k < 160; ++k) parted.columns[1].values[k] = 0.0;
  const JudgeResult judgement = judge(bouncing({chatters, passes, blind, parted}));
  EXPECT_EQ(judgement.solutions[0].contacts.at(0).verdict, ContactVerdict::untold);
  EXPECT_EQ(judgement.solutions[1].contacts.at(0).verdict, ContactVerdict::missed);
  EXPECT_EQ(judgement.solutions[2].contacts.at(0).verdict, ContactVerdict::missed);  // in none of 40
  ASSERT_EQ(judgement.solutions[3].contacts.size(), 1u);
  EXPECT_EQ(judgement.solutions[3].contacts[0].their_parts, 2u);
  EXPECT_EQ(judgement.solutions[3].contacts[0].parts, 1u);
}

Event change_at(double t, Change change, Where where = Where::left, std::size_t node = 0) {
  Event event;
  event.time = t, event.change = change, event.where = where, event.node = node;
  return event;
}

TEST(Judge, TakesContactChangesInPlaceOfSamples) {
  TheirSolution all{"changes", {}, {}, {}}, none = all, more = all;
  all.changes = {change_at(0.2, Change::closing), change_at(0.45, Change::opening)};
  none.changes.emplace();
  more.changes = {change_at(0.1, Change::closing), change_at(0.3, Change::opening), change_at(0.7, Change::closing)};
  const JudgeResult judgement = judge(bouncing({all, none, more}));
  const JudgedContact& found = judgement.solutions[0].contacts.at(0);
  EXPECT_NEAR(found.delay().value(), 0.1, 1e-12);
  EXPECT_NEAR(found.longer().value(), 0.05, 1e-12);
  EXPECT_EQ(judgement.solutions[1].count(ContactVerdict::missed), 1u);
  EXPECT_EQ(judgement.solutions[2].count(ContactVerdict::made_up), 1u);
  EXPECT_NEAR(judgement.solutions[2].contacts.at(0).delay().value(), 0.0, 1e-12);
  all.changes->front().where = Where::span;
  EXPECT_THROW(judge(bouncing({all})), std::invalid_argument);
}

// A blip that ends less than a bounce before the bar's contact is a part of it, and so is what follows.
TEST(Judge, ABlipJustBeforeAContactIsAPartOfIt) {
  TheirSolution theirs{"changes", {}, {}, {}};
  theirs.changes = {change_at(0.099, Change::closing), change_at(0.0995, Change::opening),
                    change_at(0.15, Change::closing), change_at(0.3, Change::opening)};
  const JudgeResult judgement = judge(bouncing({theirs}));
  EXPECT_EQ(judgement.solutions[0].count(ContactVerdict::made_up), 0u);
  const JudgedContact& found = judgement.solutions[0].contacts.at(0);
  EXPECT_EQ(found.verdict, ContactVerdict::found);
  EXPECT_NEAR(found.delay().value(), -0.001, 1e-12);
  EXPECT_NEAR(found.longer().value(), 0.001, 1e-12);
}

// A bar that falls flat on a span and stays there: u = -t until 0.1.
TEST(Judge, SeesContactsAlongASpanAtAPlaceAndByChanges) {
  TheirSolution at_a_place{"place", {}, {{"u@0.4", {}}}, {}}, by_changes{"changes", {}, {}, {}};
  for (std::size_t k = 0; k <= 200; ++k) {
    at_a_place.times.push_back(0.005 * static_cast<double>(k));
    at_a_place.columns[0].values.push_back(-std::clamp(at_a_place.times.back() - 0.3, 0.0, 0.1));
  }
  by_changes.changes = {
      change_at(0.15, Change::closing, Where::span, 7), change_at(0.2, Change::closing, Where::span, 8),
      change_at(0.5, Change::opening, Where::span, 7), change_at(0.7, Change::opening, Where::span, 8)};
  JudgeStudy study = study_of({at_a_place, by_changes});
  study.scene.scene.left = Free{};
  study.scene.scene.span = Obstacle{0.1};
  study.scene.method = MethodName::fully_discrete;
  study.scene.end = 1.0;
  const JudgeResult judgement = judge(study);
  const JudgedContact &place = judgement.solutions[0].contacts.at(0), &anywhere = judgement.solutions[1].contacts.at(0);
  EXPECT_EQ(place.place.value(), 0.4);
  EXPECT_NEAR(place.delay().value(), 0.3, 0.01);
  EXPECT_FALSE(anywhere.place);
  EXPECT_NEAR(anywhere.delay().value(), 0.05, 0.005);  // a step of ours
  EXPECT_EQ(anywhere.their_end.value(), 0.7);
}

// In flight as a whole, 10 % too fast: 0.21 / 2 of bar, mass and nothing else.
TEST(Judge, CountsTheMassOnAnEnd) {
  TheirSolution theirs{"fast", {0.0, 0.02, 0.04}, {}, {}};
  for (const char* place : {"_left", "_right", "@0.5"}) {
    theirs.columns.push_back({std::string("u") + place, {0.0, -0.02, -0.04}});
    theirs.columns.push_back({std::string("v") + place, {-1.1, -1.1, -1.1}});
  }
  JudgeStudy study = study_of({theirs});
  study.scene.scene.left_input.mass = 3.0;
  EXPECT_NEAR(judge(study).solutions[0].energy_drift.value(), 0.5 * 0.21 * (1.0 + 3.0), 1e-9);
}

}  // namespace
}  // namespace viscobar::testing_judge
