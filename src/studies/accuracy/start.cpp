// A search that begins where a neighbour's ended.
#include <algorithm>

#include "studies/accuracy/plan.hpp"

namespace viscobar {

AccuracyStart start_at(const Case& solution) {
  AccuracyStart start;
  if (solution.method == MethodName::characteristics) return start;
  start.elements = solution.elements;
  if (!is_scheme(solution.method) && solution.method != MethodName::exponential)
    start.tolerance = solution.tolerance.relative;
  if (is_penalised(solution.method)) start.epsilon = solution.epsilon;
  return start;
}

namespace accuracy {

// A solution of J elements came after meshes of K, K/2 and K/4, J being above K and 2 K at most, K mostly a power of
// two. The search begins with the latter two, which the estimate needs anyway. Where the power of theory is 2, J is 2
// K. Tolerance and penalty are the finer of the neighbour's and one's own guess, until runs show their errors.
void Plan::begin_at(const AccuracyStart& start) {
  const AccuracyRequest::Given& given = study_.request.given;
  const std::size_t finest = theory_ > 2.0 ? doubled_unit(start.elements) / 4 : multiple(start.elements) / 4;
  begun_ = !given.elements && finest > pilot_elements_ && affordable(finest);
  if (begun_) {
    // The coarser one, too, if it has as many elements as the estimate compares settings on.
    const std::size_t half = finest / 2;
    timed_elements_ = half >= std::max(pilot_elements_, start.elements / coarser()) ? half : finest;
    pilot_elements_ = finest;
  }
  if (start.tolerance && !stepping_ && !exact_time_ && !given.tolerance)
    chosen_.fineness = std::min(chosen_.fineness, *start.tolerance);
  if (start.epsilon && penalised_ && !given.epsilon) chosen_.epsilon = std::min(chosen_.epsilon, *start.epsilon);
  begun_ = begun_ || chosen_ != guess_;
}

// A neighbour may need far finer settings than this case. The search then goes back to its own guess.
void Plan::leave_fine_settings() {
  constexpr double far = 10.0;
  if (chosen_.fineness < guess_.fineness && far * time_error(coarse()).error < shares_.time * *requested_)
    chosen_.fineness = guess_.fineness;
  if (chosen_.epsilon < guess_.epsilon && far * penalty_error(coarse()).error < shares_.penalty * *requested_)
    chosen_.epsilon = guess_.epsilon;
}

}  // namespace accuracy
}  // namespace viscobar
