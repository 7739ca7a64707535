#include <cvode/cvode.h>

#include "integration/sundials/return_flags.hpp"

namespace viscobar::sundials {

std::span<const ReturnFlag> cvode_flags() {
  static constexpr ReturnFlag flags[] = {
      {CV_TOO_MUCH_WORK, "too many steps before the end", remedy::length},
      {CV_TOO_MUCH_ACC, "the tolerances ask for more digits than a number has", remedy::rounding},
      {CV_ERR_FAILURE, "no step, however short, keeps the tolerance", remedy::accuracy},
      {CV_CONV_FAILURE, "the equations of a step could not be solved, however short it was", remedy::stiffness},
      {CV_LINIT_FAIL, "the linear solver could not be set up", remedy::report},
      {CV_LSETUP_FAIL, "the matrix of a step could not be factorised", remedy::stiffness},
      {CV_LSOLVE_FAIL, "the linear system of a step could not be solved", remedy::stiffness},
      {CV_RHSFUNC_FAIL, "the forces could not be evaluated", remedy::load},
      {CV_FIRST_RHSFUNC_ERR, "the forces could not be evaluated where a leg begins", remedy::load},
      {CV_REPTD_RHSFUNC_ERR, "the forces could not be evaluated, however short the step was", remedy::load},
      {CV_UNREC_RHSFUNC_ERR, "the forces stopped being computable, and no shorter step avoids it", remedy::load},
      {CV_RTFUNC_FAIL, "the search for roots failed, which viscobar does by itself", remedy::report},
      {CV_NLS_INIT_FAIL, "the step solver could not be set up", remedy::report},
      {CV_NLS_SETUP_FAIL, "the step solver could not be prepared for a step", remedy::report},
      {CV_CONSTR_FAIL, "sign constraints could not be kept, which viscobar does not set", remedy::report},
      {CV_NLS_FAIL, "the equations of a step have no finite solution", remedy::stiffness},
      {CV_MEM_FAIL, "memory is exhausted", remedy::memory},
      {CV_MEM_NULL, "the integrator was used before it was made", remedy::report},
      {CV_ILL_INPUT, "the integrator was given something it cannot begin with", remedy::rounding},
      {CV_NO_MALLOC, "the integrator was used before it was started", remedy::report},
      {CV_BAD_K, "a derivative was asked for that the step's polynomial does not have", remedy::report},
      {CV_BAD_T, "the solution was asked for outside of the last step", remedy::report},
      {CV_BAD_DKY, "the solution was asked for without a place to put it", remedy::report},
      {CV_TOO_CLOSE, "what is left to the end is no more than the rounding of the time", remedy::times},
      {CV_VECTOROP_ERR, "a vector operation failed", remedy::report},
      {CV_PROJ_MEM_NULL, "a projection was asked for, which viscobar does not use", remedy::report},
      {CV_PROJFUNC_FAIL, "a projection failed, which viscobar does not use", remedy::report},
      {CV_REPTD_PROJFUNC_ERR, "a projection failed again and again, which viscobar does not use", remedy::report},
      {CV_CONTEXT_ERR, "the library's context is damaged", remedy::report},
      {CV_UNRECOGNIZED_ERR, "the library met an error that it has no name for", remedy::report},
  };
  return flags;
}

}  // namespace viscobar::sundials
