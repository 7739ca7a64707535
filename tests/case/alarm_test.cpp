#include "case/alarm.hpp"

#include <gtest/gtest.h>

#include "support/paper_throw.hpp"

namespace viscobar {
namespace {

Case throw_by(MethodName method) {
  Case run = paper_throw(0.01);
  run.method = method;
  run.restitution = 0.0;
  return run;
}

struct Sounded {
  Case run;
  BarSystem system;
  Statistics statistics;
  explicit Sounded(MethodName method) : run(throw_by(method)), system(make_system(run)) {
    Observers observers;
    observers.energy = true;
    statistics = simulate(run, system, observers);
  }
  std::vector<Alarm> operator()() const { return alarms(run, system, statistics); }
};

TEST(Alarm, IsSilentOnSoundRuns) {
  for (const MethodName method :
       {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint, MethodName::exponential})
    EXPECT_TRUE(Sounded(method)().empty()) << name(method);
}

TEST(Alarm, NamesABalanceThatIsOff) {
  Sounded run(MethodName::arkode);
  run.statistics.energy->final += 1e-3 * run.statistics.energy->initial;
  ASSERT_EQ(run().size(), 1u);
  EXPECT_FALSE(run()[0].ruinous);
  EXPECT_NE(run()[0].what.find("balance"), std::string::npos);
  run.statistics.energy->final = 1737.0;  // beside 0.25, as from an interpolation of the spring's oscillation
  EXPECT_TRUE(run()[0].ruinous);
}

TEST(Alarm, NamesEnergyFromNowhere) {
  Sounded run(MethodName::arkode);
  EnergyAccount& energy = *run.statistics.energy;
  energy.final += 2.0 * energy.dissipated;
  energy.dissipated = -energy.dissipated;
  ASSERT_EQ(run().size(), 1u);
  EXPECT_NE(run()[0].what.find("without a cause"), std::string::npos);
}

TEST(Alarm, NamesAPenetrationThatNoEnergyExplains) {
  Sounded run(MethodName::arkode);
  run.statistics.max_penetration = 1.0;
  ASSERT_EQ(run().size(), 1u);
  EXPECT_TRUE(run()[0].ruinous);
}

TEST(Alarm, NamesAnOpeningWithAPullLeft) {
  Sounded run(MethodName::arkode);
  EXPECT_LT(run.statistics.late_opening.ratio, 1.0);
  run.statistics.late_opening = {20.0, 1.5};
  ASSERT_EQ(run().size(), 1u);
  EXPECT_NE(run()[0].what.find("1.5"), std::string::npos);
}

}  // namespace
}  // namespace viscobar
