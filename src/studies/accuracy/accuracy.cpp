#include "viscobar/studies/accuracy/accuracy.hpp"

#include "studies/accuracy/plan.hpp"

namespace viscobar {

AccuracyResult solve(const AccuracyStudy& study) {
  accuracy::Plan plan(study);
  AccuracyResult result;
  do {
    result.run = plan.next();
    result.estimate = plan.judge();
  } while (plan.again());
  return result;
}

}  // namespace viscobar
