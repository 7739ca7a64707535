#pragma once

#include <sundials/sundials_config.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_nonlinearsolver.h>
#include <sundials/sundials_nvector.h>

#include <cstdlib>
#include <memory>
#include <new>
#include <string>

// Everything that differs between the versions 6.4 and 7.x of SUNDIALS is in this file.

namespace viscobar::sundials {

// Without memory for it, a message is lost.
inline void keep_message(const char* message, void* sink) noexcept try {
  *static_cast<std::string*>(sink) = message;
} catch (const std::bad_alloc&) {
}

/// VISCOBAR_KEEP_MESSAGES(package, memory, context, sink): what the library would print goes into the string `sink`.
#if SUNDIALS_VERSION_MAJOR >= 7
using boolean = sunbooleantype;
inline constexpr auto no_communicator = SUN_COMM_NULL;
inline void keep_message(int, const char*, const char*, const char* message, SUNErrCode, void* sink,
                         SUNContext) noexcept {
  keep_message(message, sink);
}
#define VISCOBAR_KEEP_MESSAGES(package, memory, context, sink) \
  SUNContext_PushErrHandler((context).get(), viscobar::sundials::keep_message, &(sink))
#else
using boolean = booleantype;
inline constexpr void* no_communicator = nullptr;
inline void keep_message(int, const char*, const char*, char* message, void* sink) noexcept {
  keep_message(message, sink);
}
#define VISCOBAR_KEEP_MESSAGES(package, memory, context, sink) \
  package##SetErrHandlerFn((memory), viscobar::sundials::keep_message, &(sink))
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

/// The name of a return flag; the library hands out memory that the caller frees.
inline std::string flag_name(char* name) {
  const std::unique_ptr<char, decltype(&std::free)> owned(name, &std::free);
  return owned.get();
}

}  // namespace viscobar::sundials
