#include "integration/sundials/return_flags.hpp"

#include <arkode/arkode.h>
#include <cvode/cvode.h>
#include <ida/ida.h>

#include <algorithm>

namespace viscobar::sundials {

std::span<const ReturnFlag> cvode_flags() {
  static constexpr ReturnFlag flags[] = {
      {CV_TOO_MUCH_WORK, "too many steps before the end", Failure::length},
      {CV_TOO_MUCH_ACC, "the tolerances ask for more digits than a number has", Failure::digits},
      {CV_ERR_FAILURE, "no step, however short, keeps the tolerance", Failure::accuracy},
      {CV_CONV_FAILURE, "the equations of a step could not be solved, however short it was", Failure::stiffness},
      {CV_LSETUP_FAIL, "the matrix of a step could not be factorised", Failure::stiffness},
      {CV_LSOLVE_FAIL, "the linear system of a step could not be solved", Failure::stiffness},
      {CV_RHSFUNC_FAIL, "the forces could not be evaluated", Failure::load},
      {CV_FIRST_RHSFUNC_ERR, "the forces could not be evaluated where a leg begins", Failure::load},
      {CV_REPTD_RHSFUNC_ERR, "the forces could not be evaluated, however short the step was", Failure::load},
      {CV_UNREC_RHSFUNC_ERR, "the forces stopped being computable, and no shorter step avoids it", Failure::load},
      {CV_NLS_FAIL, "the equations of a step have no finite solution", Failure::stiffness},
      {CV_MEM_FAIL, "memory is exhausted", Failure::memory},
      {CV_ILL_INPUT, "the integrator was given something it cannot begin with", Failure::digits},
      {CV_TOO_CLOSE, "what is left to the end is no more than the rounding of the time", Failure::short_end},
  };
  return flags;
}

std::span<const ReturnFlag> ida_flags() {
  static constexpr ReturnFlag flags[] = {
      {IDA_TOO_MUCH_WORK, "too many steps before the end", Failure::length},
      {IDA_TOO_MUCH_ACC, "the tolerances ask for more digits than a number has", Failure::digits},
      {IDA_ERR_FAIL, "no step, however short, keeps the tolerance", Failure::accuracy},
      {IDA_CONV_FAIL, "the equations of a step could not be solved, however short it was", Failure::stiffness},
      {IDA_LSETUP_FAIL, "the matrix of a step could not be factorised", Failure::stiffness},
      {IDA_LSOLVE_FAIL, "the linear system of a step could not be solved", Failure::stiffness},
      {IDA_RES_FAIL, "the forces could not be evaluated", Failure::load},
      {IDA_REP_RES_ERR, "the forces could not be evaluated, however short the step was", Failure::load},
      {IDA_FIRST_RES_FAIL, "the forces could not be evaluated where a leg begins", Failure::load},
      {IDA_NO_RECOVERY, "the forces stopped being computable, and no shorter step avoids it", Failure::load},
      {IDA_NLS_FAIL, "the equations of a step have no finite solution", Failure::stiffness},
      {IDA_MEM_FAIL, "memory is exhausted", Failure::memory},
      {IDA_ILL_INPUT,
       "the integrator was given something it cannot begin with, or what is left to the end is no more than the "
       "rounding of the time",
       Failure::short_end},
      {IDA_BAD_EWT, "the tolerances leave nothing to measure an error by", Failure::digits},
  };
  return flags;
}

std::span<const ReturnFlag> arkode_flags() {
  static constexpr ReturnFlag flags[] = {
      {ARK_TOO_MUCH_WORK, "too many steps before the end", Failure::length},
      {ARK_TOO_MUCH_ACC, "the tolerances ask for more digits than a number has", Failure::digits},
      {ARK_ERR_FAILURE, "no step, however short, keeps the tolerance", Failure::accuracy},
      {ARK_CONV_FAILURE, "the equations of a stage could not be solved, however short the step was",
       Failure::stiffness},
      {ARK_LSETUP_FAIL, "the matrix of a stage could not be factorised", Failure::stiffness},
      {ARK_LSOLVE_FAIL, "the linear system of a stage could not be solved", Failure::stiffness},
      {ARK_RHSFUNC_FAIL, "the forces could not be evaluated", Failure::load},
      {ARK_FIRST_RHSFUNC_ERR, "the forces could not be evaluated where a leg begins", Failure::load},
      {ARK_REPTD_RHSFUNC_ERR, "the forces could not be evaluated, however short the step was", Failure::load},
      {ARK_UNREC_RHSFUNC_ERR, "the forces stopped being computable, and no shorter step avoids it", Failure::load},
      {ARK_MEM_FAIL, "memory is exhausted", Failure::memory},
      {ARK_ILL_INPUT, "the integrator was given something it cannot begin with", Failure::digits},
      {ARK_TOO_CLOSE, "what is left to the end is no more than the rounding of the time", Failure::short_end},
      {ARK_NLS_SETUP_RECVR, "the stage solver could not be prepared, however short the step was", Failure::stiffness},
      {ARK_NLS_OP_ERR, "the equations of a stage have no finite solution", Failure::stiffness},
  };
  return flags;
}

const ReturnFlag& return_flag(std::span<const ReturnFlag> flags, int value) {
  static constexpr ReturnFlag defect{0, "the library failed by no fault of the scene", Failure::defect};
  const auto found = std::ranges::find(flags, value, &ReturnFlag::value);
  return found == flags.end() ? defect : *found;
}

}  // namespace viscobar::sundials
