// What a stiff contact costs: the steps follow the motion, not the penalty or the mesh.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/paper_throw.hpp"
#include "viscobar/analysis/end_traces.hpp"

namespace viscobar {
namespace {

std::size_t steps(MethodName method, std::size_t elements, double epsilon, Tolerance tolerance) {
  Case run = paper_throw(1.0);
  run.mass = Mass::redistributed;
  run.method = method;
  run.elements = elements;
  run.epsilon = epsilon;
  run.tolerance = tolerance;
  const Statistics statistics = trace_ends(run, std::vector{0.0, run.end}).statistics;
  EXPECT_EQ(statistics.events, 2u) << elements << " " << epsilon;
  return statistics.steps;
}

class StiffContact : public testing::TestWithParam<MethodName> {};

TEST_P(StiffContact, CostsNoMoreStepsAtAStifferPenalty) {
  for (const double relative : {1e-6, 1e-8}) {
    const Tolerance tolerance{relative, 1e-3 * relative};
    const std::size_t soft = steps(GetParam(), 54, 1e-3, tolerance);
    for (const double epsilon : {1e-5, 1e-8, 1e-11})
      EXPECT_LT(steps(GetParam(), 54, epsilon, tolerance), 2 * soft) << relative << " " << epsilon;
  }
}

// A unit of rounding of u at the contact is, through viscosity, a velocity of eta / (rho h^2) units beside it: far more
// than 1e-10 on the finer mesh. An error test that saw it would shrink the step to that of the rounding.
TEST_P(StiffContact, DoesNotChaseTheRoundingOfAClosedContactOnAFineMesh) {
  const Tolerance tolerance{1e-10, 1e-13};
  EXPECT_LT(steps(GetParam(), 432, 1e-10, tolerance), 10 * steps(GetParam(), 27, 1e-10, tolerance));
}

INSTANTIATE_TEST_SUITE_P(Methods, StiffContact, testing::Values(MethodName::cvode, MethodName::ida));

}  // namespace
}  // namespace viscobar
