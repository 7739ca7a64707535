#include "integration/sundials/return_flags.hpp"

#include <arkode/arkode.h>
#include <cvode/cvode.h>
#include <ida/ida.h>

#include <algorithm>

namespace viscobar::sundials {

std::span<const ReturnFlag> return_flags() {
  using enum Failure;
  static constexpr ReturnFlag flags[] = {
      {{CV_TOO_MUCH_WORK, IDA_TOO_MUCH_WORK, ARK_TOO_MUCH_WORK}, "too many steps before the end", length},
      {{CV_TOO_MUCH_ACC, IDA_TOO_MUCH_ACC, ARK_TOO_MUCH_ACC},
       "the tolerances ask for more digits than a number has",
       digits},
      {{CV_ERR_FAILURE, IDA_ERR_FAIL, ARK_ERR_FAILURE}, "no step, however short, keeps the tolerance", accuracy},
      {{CV_CONV_FAILURE, IDA_CONV_FAIL, ARK_CONV_FAILURE},
       "the equations of a step could not be solved, however short it was",
       stiffness},
      {{CV_LSETUP_FAIL, IDA_LSETUP_FAIL, ARK_LSETUP_FAIL}, "the matrix of a step could not be factorised", stiffness},
      {{CV_LSOLVE_FAIL, IDA_LSOLVE_FAIL, ARK_LSOLVE_FAIL},
       "the linear system of a step could not be solved",
       stiffness},
      {{CV_RHSFUNC_FAIL, IDA_RES_FAIL, ARK_RHSFUNC_FAIL}, "the forces could not be evaluated", load},
      {{CV_FIRST_RHSFUNC_ERR, IDA_FIRST_RES_FAIL, ARK_FIRST_RHSFUNC_ERR},
       "the forces could not be evaluated where a leg begins",
       load},
      {{CV_REPTD_RHSFUNC_ERR, IDA_REP_RES_ERR, ARK_REPTD_RHSFUNC_ERR},
       "the forces could not be evaluated, however short the step was",
       load},
      {{CV_UNREC_RHSFUNC_ERR, IDA_NO_RECOVERY, ARK_UNREC_RHSFUNC_ERR},
       "the forces stopped being computable, and no shorter step avoids it",
       load},
      {{CV_NLS_FAIL, IDA_NLS_FAIL, ARK_NLS_OP_ERR}, "the equations of a step have no finite solution", stiffness},
      {{CV_MEM_FAIL, IDA_MEM_FAIL, ARK_MEM_FAIL}, "memory is exhausted", memory},
      {{CV_ILL_INPUT, 0, ARK_ILL_INPUT}, "the integrator was given something it cannot begin with", digits},
      {{CV_TOO_CLOSE, 0, ARK_TOO_CLOSE}, "what is left to the end is no more than the rounding of the time", short_end},
      {{0, IDA_ILL_INPUT, 0},
       "the integrator was given something it cannot begin with, or what is left to the end is no more than the "
       "rounding of the time",
       short_end},
      {{0, IDA_BAD_EWT, 0}, "the tolerances leave nothing to measure an error by", digits},
      {{0, 0, ARK_NLS_SETUP_RECVR}, "the stage solver could not be prepared, however short the step was", stiffness},
  };
  return flags;
}

const ReturnFlag& return_flag(Library library, int value) {
  static constexpr ReturnFlag defect{{}, "the library failed by no fault of the scene", Failure::defect};
  const auto flags = return_flags();
  const auto found = std::ranges::find_if(
      flags, [&](const ReturnFlag& one) { return one.values[static_cast<std::size_t>(library)] == value; });
  return value < 0 && found != flags.end() ? *found : defect;
}

}  // namespace viscobar::sundials
