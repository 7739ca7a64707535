#include "viscobar/studies/limit/coupling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/paper_throw.hpp"

namespace viscobar {
namespace {

std::vector<double> differences(const std::vector<double>& h, double q, double K) {
  std::vector<double> d;
  for (std::size_t i = 0; i + 1 < h.size(); ++i) d.push_back(K * (std::pow(h[i], q) - std::pow(h[i + 1], q)));
  return d;
}

TEST(MeshError, FindsThePowerOfHAlsoOnMeshesWithoutACommonRatio) {
  for (const double q : {0.5, 1.0, 1.7, 2.0}) {
    const std::vector<double> h = {1.0 / 10, 1.0 / 27, 1.0 / 40, 1.0 / 108};
    const auto found = mesh_error(h, differences(h, q, 3.0));
    ASSERT_TRUE(found);
    // The order is enclosed to 1e-6; K h^q at h = 1/40 .. 1/108 then moves by a factor below 108^1e-6 and as much
    // again.
    EXPECT_NEAR(found->order, q, 1e-6);
    EXPECT_NEAR(found->constant, 3.0, 6.0 * (std::pow(108.0, 1e-6) - 1.0));
  }
}

TEST(MeshError, IsAbsentWhereTheDataCarryNone) {
  EXPECT_FALSE(mesh_error({0.1, 0.05}, {1e-3}));
  EXPECT_FALSE(mesh_error({0.1, 0.05, 0.025}, {1e-3, 2e-3})) << "differences that grow are no convergence";
  EXPECT_FALSE(mesh_error({0.1, 0.05, 0.025}, {1.0, 1e-4})) << "steeper than any order in question";
}

// The limits are run once more, which may take minutes.
TEST(BalanceErrors, HearsAnInterrupt) {
  LimitStudy study;
  study.scene = paper_throw(0.01);
  study.scene.mass = Mass::redistributed;
  study.scene.end = study.scene.output_every = 1e7;
  unsigned asked = 0;
  study.interrupted = [&] { return ++asked > 100; };
  LimitResult result;
  for (const std::size_t elements : {27, 54, 108}) {
    result.orders.emplace_back();
    result.orders.back().elements = elements;
    result.orders.back().scheme_step = 1e-3;
  }
  const CouplingResult found = balance_errors(study, result);
  EXPECT_FALSE(found.coupling);
  EXPECT_EQ(found.reason, "it was interrupted");
}

}  // namespace
}  // namespace viscobar
