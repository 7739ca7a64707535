#include <arkode/arkode.h>

#include "integration/sundials/return_flags.hpp"

namespace viscobar::sundials {

std::span<const ReturnFlag> arkode_flags() {
  static constexpr ReturnFlag flags[] = {
      {ARK_TOO_MUCH_WORK, "too many steps before the end", remedy::length},
      {ARK_TOO_MUCH_ACC, "the tolerances ask for more digits than a number has", remedy::rounding},
      {ARK_ERR_FAILURE, "no step, however short, keeps the tolerance", remedy::accuracy},
      {ARK_CONV_FAILURE, "the equations of a stage could not be solved, however short the step was", remedy::stiffness},
      {ARK_LINIT_FAIL, "the linear solver could not be set up", remedy::report},
      {ARK_LSETUP_FAIL, "the matrix of a stage could not be factorised", remedy::stiffness},
      {ARK_LSOLVE_FAIL, "the linear system of a stage could not be solved", remedy::stiffness},
      {ARK_RHSFUNC_FAIL, "the forces could not be evaluated", remedy::load},
      {ARK_FIRST_RHSFUNC_ERR, "the forces could not be evaluated where a leg begins", remedy::load},
      {ARK_REPTD_RHSFUNC_ERR, "the forces could not be evaluated, however short the step was", remedy::load},
      {ARK_UNREC_RHSFUNC_ERR, "the forces stopped being computable, and no shorter step avoids it", remedy::load},
      {ARK_RTFUNC_FAIL, "the search for roots failed, which viscobar does by itself", remedy::report},
      {ARK_LFREE_FAIL, "the linear solver could not be given up", remedy::report},
      {ARK_MASSINIT_FAIL, "the solver of the mass could not be set up, which viscobar does not use", remedy::report},
      {ARK_MASSSETUP_FAIL, "the mass could not be factorised, which the library is not asked for", remedy::report},
      {ARK_MASSSOLVE_FAIL, "a system with the mass could not be solved, which the library is not asked for",
       remedy::report},
      {ARK_MASSFREE_FAIL, "the solver of the mass could not be given up, which viscobar does not use", remedy::report},
      {ARK_MASSMULT_FAIL, "a product with the mass failed, which the library is not asked for", remedy::report},
      {ARK_CONSTR_FAIL, "sign constraints could not be kept, which viscobar does not set", remedy::report},
      {ARK_MEM_FAIL, "memory is exhausted", remedy::memory},
      {ARK_MEM_NULL, "the integrator was used before it was made", remedy::report},
      {ARK_ILL_INPUT, "the integrator was given something it cannot begin with", remedy::rounding},
      {ARK_NO_MALLOC, "the integrator was used before it was started", remedy::report},
      {ARK_BAD_K, "a derivative was asked for that the step's polynomial does not have", remedy::report},
      {ARK_BAD_T, "the solution was asked for outside of the last step", remedy::report},
      {ARK_BAD_DKY, "the solution was asked for without a place to put it", remedy::report},
      {ARK_TOO_CLOSE, "what is left to the end is no more than the rounding of the time", remedy::times},
      {ARK_VECTOROP_ERR, "a vector operation failed", remedy::report},
      {ARK_NLS_INIT_FAIL, "the stage solver could not be set up", remedy::report},
      {ARK_NLS_SETUP_FAIL, "the stage solver could not be prepared for a step", remedy::report},
      {ARK_NLS_SETUP_RECVR, "the stage solver could not be prepared, however short the step was", remedy::stiffness},
      {ARK_NLS_OP_ERR, "the equations of a stage have no finite solution", remedy::stiffness},
      {ARK_INNERSTEP_ATTACH_ERR, "an inner integrator was missing, which viscobar does not use", remedy::report},
      {ARK_INNERSTEP_FAIL, "an inner integrator failed, which viscobar does not use", remedy::report},
      {ARK_OUTERTOINNER_FAIL, "data for an inner integrator failed, which viscobar does not use", remedy::report},
      {ARK_INNERTOOUTER_FAIL, "data of an inner integrator failed, which viscobar does not use", remedy::report},
      {ARK_POSTPROCESS_STEP_FAIL, "what follows a step failed, which viscobar does not set", remedy::report},
      {ARK_POSTPROCESS_STAGE_FAIL, "what follows a stage failed, which viscobar does not set", remedy::report},
      {ARK_USER_PREDICT_FAIL, "a prediction of the stages failed, which viscobar does not set", remedy::report},
      {ARK_INTERP_FAIL, "the library's own interpolation failed, which viscobar does not use", remedy::report},
      {ARK_INVALID_TABLE, "the Runge-Kutta formulas were refused", remedy::report},
      {ARK_CONTEXT_ERR, "the library's context is damaged", remedy::report},
      {ARK_UNRECOGNIZED_ERROR, "the library met an error that it has no name for", remedy::report},
  };
  return flags;
}

}  // namespace viscobar::sundials
