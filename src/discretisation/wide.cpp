#include "discretisation/wide.hpp"

namespace viscobar {

namespace {

std::size_t widest() {
#ifdef VISCOBAR_WIDTHS
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f")) return 8;
  if (__builtin_cpu_supports("avx2")) return 4;
#endif
  return compiled_width;
}

}  // namespace

std::size_t register_width = widest();

}  // namespace viscobar
