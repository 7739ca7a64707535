#pragma once

#include <cstdlib>
#include <new>

/// Counts what this program allocates by `new`. For one source file a test program: it replaces the global operators.
namespace viscobar::testing_support {
inline std::size_t allocations = 0;
}

void* operator new(std::size_t size) {
  ++viscobar::testing_support::allocations;
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
