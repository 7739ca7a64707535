#pragma once

#include <pthread.h>

#include <memory>
#include <new>

namespace viscobar {

/// A value of its own for each thread, until the thread ends. Where there is no memory to register its destructor, a
/// thread_local ends the program [glibc, __cxa_thread_atexit]; this throws. One for each `static`: keys are few.
template <class Value>
class OfThread {
 public:
  OfThread() {
    if (pthread_key_create(&key_, [](void* own) { delete static_cast<Value*>(own); }) != 0) throw std::bad_alloc();
  }

  Value* if_any() const { return static_cast<Value*>(pthread_getspecific(key_)); }

  /// @throws std::bad_alloc
  Value& operator*() const {
    if (Value* own = if_any()) return *own;
    auto made = std::make_unique<Value>();
    if (pthread_setspecific(key_, made.get()) != 0) throw std::bad_alloc();
    return *made.release();
  }

 private:
  pthread_key_t key_{};
};

}  // namespace viscobar
