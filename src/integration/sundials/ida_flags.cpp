#include <ida/ida.h>

#include "integration/sundials/return_flags.hpp"

namespace viscobar::sundials {

std::span<const ReturnFlag> ida_flags() {
  static constexpr ReturnFlag flags[] = {
      {IDA_TOO_MUCH_WORK, "too many steps before the end", remedy::length},
      {IDA_TOO_MUCH_ACC, "the tolerances ask for more digits than a number has", remedy::rounding},
      {IDA_ERR_FAIL, "no step, however short, keeps the tolerance", remedy::accuracy},
      {IDA_CONV_FAIL, "the equations of a step could not be solved, however short it was", remedy::stiffness},
      {IDA_LINIT_FAIL, "the linear solver could not be set up", remedy::report},
      {IDA_LSETUP_FAIL, "the matrix of a step could not be factorised", remedy::stiffness},
      {IDA_LSOLVE_FAIL, "the linear system of a step could not be solved", remedy::stiffness},
      {IDA_RES_FAIL, "the forces could not be evaluated", remedy::load},
      {IDA_REP_RES_ERR, "the forces could not be evaluated, however short the step was", remedy::load},
      {IDA_RTFUNC_FAIL, "the search for roots failed, which viscobar does by itself", remedy::report},
      {IDA_CONSTR_FAIL, "sign constraints could not be kept, which viscobar does not set", remedy::report},
      {IDA_FIRST_RES_FAIL, "the forces could not be evaluated where a leg begins", remedy::load},
      {IDA_LINESEARCH_FAIL, "consistent initial data were not found by the library, which viscobar finds by itself",
       remedy::report},
      {IDA_NO_RECOVERY, "the forces stopped being computable, and no shorter step avoids it", remedy::load},
      {IDA_NLS_INIT_FAIL, "the step solver could not be set up", remedy::report},
      {IDA_NLS_SETUP_FAIL, "the step solver could not be prepared for a step", remedy::report},
      {IDA_NLS_FAIL, "the equations of a step have no finite solution", remedy::stiffness},
      {IDA_MEM_NULL, "the integrator was used before it was made", remedy::report},
      {IDA_MEM_FAIL, "memory is exhausted", remedy::memory},
      {IDA_ILL_INPUT,
       "the integrator was given something it cannot begin with, or what is left to the end is no more "
       "than the rounding of the time",
       remedy::times},
      {IDA_NO_MALLOC, "the integrator was used before it was started", remedy::report},
      {IDA_BAD_EWT, "the tolerances leave nothing to measure an error by", remedy::rounding},
      {IDA_BAD_K, "a derivative was asked for that the step's polynomial does not have", remedy::report},
      {IDA_BAD_T, "the solution was asked for outside of the last step", remedy::report},
      {IDA_BAD_DKY, "the solution was asked for without a place to put it", remedy::report},
      {IDA_VECTOROP_ERR, "a vector operation failed", remedy::report},
      {IDA_CONTEXT_ERR, "the library's context is damaged", remedy::report},
      {IDA_UNRECOGNIZED_ERROR, "the library met an error that it has no name for", remedy::report},
  };
  return flags;
}

}  // namespace viscobar::sundials
