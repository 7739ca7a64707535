#pragma once

#include <arkode/arkode_arkstep.h>
#include <sundials/sundials_config.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_nonlinearsolver.h>
#include <sundials/sundials_nvector.h>

#include <cstdlib>
#include <memory>
#include <new>
#include <string>
#include <type_traits>

#if SUNDIALS_VERSION_MAJOR >= 7
#include <sunadaptcontroller/sunadaptcontroller_soderlind.h>
#endif

// Everything that differs between the versions 6.4 and 7.x of SUNDIALS is in this file.

namespace viscobar::sundials {

// Without memory for it, a message is lost.
inline void keep_message(const char* message, void* sink) noexcept try {
  *static_cast<std::string*>(sink) = message;
} catch (const std::bad_alloc&) {
}

/// VISCOBAR_KEEP_MESSAGES(package, memory, context, sink): what the library would print goes into the string `sink`.
///
/// make_context(): a context in which the library prints nothing; 0, or an error.
#if SUNDIALS_VERSION_MAJOR >= 7
using boolean = sunbooleantype;
inline void free_context(SUNContext* context) {
  SUNLogger silent = nullptr;
  SUNContext_GetLogger(*context, &silent);
  SUNContext_Free(context);
  SUNLogger_Destroy(&silent);
}
inline int make_context(SUNContext* context) {
  const SUNComm alone = SUN_COMM_NULL;
  SUNLogger silent = nullptr;  // any writes warnings to standard output, unless it is given a file for them
  int failed = SUNContext_Create(alone, context);
  if (failed) return failed;
  failed = SUNLogger_Create(alone, 0, &silent);
  if (!failed) failed = SUNLogger_SetWarningFilename(silent, "/dev/null");
  if (!failed) failed = SUNContext_SetLogger(*context, silent);
  if (!failed) failed = SUNContext_ClearErrHandlers(*context);
  if (failed) SUNContext_Free(context), SUNLogger_Destroy(&silent);
  return failed;
}
inline void keep_message(int, const char*, const char*, const char* message, SUNErrCode, void* sink,
                         SUNContext) noexcept {
  keep_message(message, sink);
}
#define VISCOBAR_KEEP_MESSAGES(package, memory, context, sink) \
  SUNContext_PushErrHandler((context).get(), viscobar::sundials::keep_message, &(sink))
#else
using boolean = booleantype;
inline int make_context(SUNContext* context) { return SUNContext_Create(nullptr, context); }
inline void free_context(SUNContext* context) { SUNContext_Free(context); }
inline void keep_message(int, const char*, const char*, char* message, void* sink) noexcept {
  keep_message(message, sink);
}
#define VISCOBAR_KEEP_MESSAGES(package, memory, context, sink) \
  package##SetErrHandlerFn((memory), viscobar::sundials::keep_message, &(sink))
#endif

// Since version 7.1 the functions that all methods of ARKODE share have names of their own.
#if SUNDIALS_VERSION_MAJOR < 7 || (SUNDIALS_VERSION_MAJOR == 7 && SUNDIALS_VERSION_MINOR < 1)
inline constexpr auto ARKodeEvolve = ARKStepEvolve;
inline constexpr auto ARKodeFree = ARKStepFree;
inline constexpr auto ARKodeGetLastStep = ARKStepGetLastStep;
inline constexpr auto ARKodeGetNonlinearSystemData = ARKStepGetNonlinearSystemData;
inline constexpr auto ARKodeGetReturnFlagName = ARKStepGetReturnFlagName;
inline constexpr auto ARKodeReset = ARKStepReset;
inline constexpr auto ARKodeSetDeduceImplicitRhs = ARKStepSetDeduceImplicitRhs;
inline constexpr auto ARKodeSetInterpolantDegree = ARKStepSetInterpolantDegree;
inline constexpr auto ARKodeSetInterpolantType = ARKStepSetInterpolantType;
inline constexpr auto ARKodeSetMaxErrTestFails = ARKStepSetMaxErrTestFails;
inline constexpr auto ARKodeSetMaxStep = ARKStepSetMaxStep;
inline constexpr auto ARKodeSetNonlinearSolver = ARKStepSetNonlinearSolver;
inline constexpr auto ARKodeSetPredictorMethod = ARKStepSetPredictorMethod;
inline constexpr auto ARKodeSetInitStep = ARKStepSetInitStep;
inline constexpr auto ARKodeSetStopTime = ARKStepSetStopTime;
inline constexpr auto ARKodeSetUserData = ARKStepSetUserData;
inline constexpr auto ARKodeWFtolerances = ARKStepWFtolerances;
#endif

class HistorySums;

/// Owner of the context that every SUNDIALS object is created in, and of what its vectors have put off.
class Context {
 public:
  Context();
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  SUNContext get() const { return context_; }
  HistorySums& put_off() const { return *put_off_; }

 private:
  SUNContext context_ = nullptr;
  std::unique_ptr<HistorySums> put_off_;
};

/// Frees by a function of the library, which takes the object, or the address of the memory of an integrator.
template <auto free>
struct Freed {
  void operator()(auto* object) const noexcept {
    if constexpr (requires { free(object); })
      free(object);
    else
      free(&object);
  }
};
using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, Freed<N_VDestroy>>;
using NonlinearSolver = std::unique_ptr<std::remove_pointer_t<SUNNonlinearSolver>, Freed<SUNNonlinSolFree>>;
template <auto free>
using Memory = std::unique_ptr<void, Freed<free>>;

/// ARKODE's step sizes by the last error alone. Lives as long as the memory that it is given to.
class StepControl {
 public:
#if SUNDIALS_VERSION_MAJOR >= 7
  int give_to(void* memory, const Context& context) {
    controller_.reset(SUNAdaptController_I(context.get()));
    return controller_ ? ARKodeSetAdaptController(memory, controller_.get()) : ARK_MEM_FAIL;
  }

 private:
  std::unique_ptr<std::remove_pointer_t<SUNAdaptController>, Freed<SUNAdaptController_Destroy>> controller_;
#else
  int give_to(void* memory, const Context&) { return ARKStepSetAdaptivityMethod(memory, ARK_ADAPT_I, 1, 0, nullptr); }
#endif
};

/// The name of a return flag; the library hands out memory that the caller frees.
inline std::string flag_name(char* name) {
  const std::unique_ptr<char, decltype(&std::free)> owned(name, &std::free);
  return owned.get();
}

}  // namespace viscobar::sundials
