#include "results/field/hdf5_handle.hpp"

#include <sys/mman.h>

#include <cstdlib>
#include <new>
#include <string_view>
#include <system_error>

namespace viscobar {

std::string hdf5_cause() {
  std::string text;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned depth, const H5E_error2_t* entry, void* out) -> herr_t {
        if (depth == 0 && entry->desc) *static_cast<std::string*>(out) = entry->desc;
        return 0;
      },
      &text);
  constexpr std::string_view before = "errno = ";
  const std::size_t at = text.find(before);
  if (at == std::string::npos) return text;
  return std::generic_category().message(std::atoi(text.c_str() + at + before.size()));
}

void begin_hdf5() {
  // Its tables take one megabyte, the cache of each of five datasets another, a block of rows to pass on one more.
  constexpr std::size_t needed = 8 << 20;
  void* const room = mmap(nullptr, needed, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (room == MAP_FAILED) throw std::bad_alloc();
  munmap(room, needed);
  [[maybe_unused]] static const herr_t once = H5dont_atexit();
}

}  // namespace viscobar
