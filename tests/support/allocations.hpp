#pragma once

#include <cstdlib>
#include <new>

/// Counts what this program allocates by `new`. For one source file a test program: it replaces the global operators.
namespace viscobar::testing_support {
inline std::size_t allocations = 0;
}

// Not inline: a compiler that sees malloc() in one and `new` in the other of a pair takes them for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++viscobar::testing_support::allocations;
  return std::malloc(size ? size : 1);
}
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (void* memory = operator new(size, std::nothrow)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
