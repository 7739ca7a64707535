#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_band.h>
#include <sunmatrix/sunmatrix_band.h>

#include <algorithm>
#include <stdexcept>

#include "benchmark/baselines.hpp"
#include "integration/sundials/handles.hpp"

namespace viscobar::baseline {

namespace {

const Interleaved& bar(void* user) { return *static_cast<const Interleaved*>(user); }

int rates(sunrealtype, N_Vector y, N_Vector rate, void* user) {
  bar(user).rates(NV_DATA_S(y), NV_DATA_S(rate));
  return 0;
}

int jacobian(sunrealtype, N_Vector y, N_Vector, SUNMatrix matrix, void* user, N_Vector, N_Vector, N_Vector) {
  bar(user).jacobian(NV_DATA_S(y), [&](std::size_t row, std::size_t column, double value) {
    SM_ELEMENT_B(matrix, static_cast<sunindextype>(row), static_cast<sunindextype>(column)) = value;
  });
  return 0;
}

int clearances(sunrealtype, N_Vector y, sunrealtype* g, void* user) {
  const double* values = NV_DATA_S(y);
  g[0] = values[0] + bar(user).gap();
  g[1] = values[bar(user).size() - 2] + bar(user).gap();
  return 0;
}

void check(int flag, const char* call) {
  if (flag < 0) throw std::runtime_error(call);
}

}  // namespace

Trace stock_cvode(const Problem& problem, double relative, double absolute, AtChange change, bool adams) {
  Interleaved system(problem);
  SUNContext context = nullptr;
  check(sundials::make_context(&context), "SUNContext_Create");
  const auto size = static_cast<sunindextype>(system.size());
  N_Vector y = N_VNew_Serial(size, context);
  std::ranges::copy(system.start(), NV_DATA_S(y));
  double t = problem.times.front();
  void* memory = CVodeCreate(adams ? CV_ADAMS : CV_BDF, context);
  SUNMatrix matrix = SUNBandMatrix(size, 3, 3, context);
  SUNLinearSolver solver = SUNLinSol_Band(y, matrix, context);
  check(CVodeInit(memory, rates, t, y), "CVodeInit");
  check(CVodeSStolerances(memory, relative, absolute), "CVodeSStolerances");
  check(CVodeSetUserData(memory, &system), "CVodeSetUserData");
  check(CVodeSetLinearSolver(memory, solver, matrix), "CVodeSetLinearSolver");
  check(CVodeSetJacFn(memory, jacobian), "CVodeSetJacFn");
  check(CVodeSetMaxNumSteps(memory, 100000000), "CVodeSetMaxNumSteps");
  check(CVodeSetStopTime(memory, problem.times.back()), "CVodeSetStopTime");
  if (change != AtChange::nothing) check(CVodeRootInit(memory, 2, clearances), "CVodeRootInit");

  Trace trace;
  long steps = 0;
  const auto count_leg = [&] {
    check(CVodeGetNumSteps(memory, &steps), "CVodeGetNumSteps");
    trace.steps += static_cast<std::size_t>(steps);
  };
  trace.left.push_back(NV_DATA_S(y)[0]);
  for (std::size_t k = 1; k < problem.times.size();) {
    const int flag = CVode(memory, problem.times[k], y, &t, CV_NORMAL);
    check(flag, "CVode");
    if (flag == CV_ROOT_RETURN) {
      count_leg();
      double first = 0.0;
      if (change == AtChange::restart_kept) check(CVodeGetActualInitStep(memory, &first), "CVodeGetActualInitStep");
      if (change == AtChange::restart_last) check(CVodeGetLastStep(memory, &first), "CVodeGetLastStep"), first /= 10;
      check(CVodeReInit(memory, t, y), "CVodeReInit");
      check(CVodeSetInitStep(memory, std::min(first, problem.times.back() - t)), "CVodeSetInitStep");
      check(CVodeSetStopTime(memory, problem.times.back()), "CVodeSetStopTime");
    } else {
      trace.left.push_back(NV_DATA_S(y)[0]);
      ++k;
    }
  }
  count_leg();
  SUNLinSolFree(solver);
  SUNMatDestroy(matrix);
  CVodeFree(&memory);
  N_VDestroy(y);
  sundials::free_context(&context);
  return trace;
}

}  // namespace viscobar::baseline
