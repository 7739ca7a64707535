#include "viscobar/results/versions.hpp"

#include <elf.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <link.h>
#include <sundials/sundials_config.h>
#include <sys/utsname.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstring>
#include <span>
#include <string_view>

namespace viscobar {

namespace {

// Where the object that holds this code begins in memory: the linker defines it.
extern "C" __attribute__((visibility("hidden"))) const char __ehdr_start[];

// The identity that the linker has given this object (ld --build-id).
std::string build() {
  ElfW(Ehdr) head{};
  std::memcpy(&head, __ehdr_start, sizeof head);
  const std::span parts(reinterpret_cast<const ElfW(Phdr)*>(__ehdr_start + head.e_phoff), head.e_phnum);
  const auto first = std::ranges::find(parts, ElfW(Word){PT_LOAD}, &ElfW(Phdr)::p_type);
  const auto padded = [](std::size_t bytes) { return (bytes + 3) / 4 * 4; };
  std::string identity;
  for (const ElfW(Phdr) & part : parts) {
    if (part.p_type != PT_NOTE) continue;
    const char* at = __ehdr_start + (part.p_vaddr - first->p_vaddr);
    for (const char* const end = at + part.p_memsz; at + sizeof(ElfW(Nhdr)) <= end;) {
      ElfW(Nhdr) note{};
      std::memcpy(&note, at, sizeof note);
      const char *const name = at + sizeof note, *const value = name + padded(note.n_namesz);
      if (note.n_type == NT_GNU_BUILD_ID && std::string_view(name, note.n_namesz) == std::string_view("GNU\0", 4))
        for (std::size_t i = 0; i < note.n_descsz; ++i)
          identity += fmt::format("{:02x}", static_cast<unsigned char>(value[i]));
      at = value + padded(note.n_descsz);
    }
  }
  return identity.empty() ? "unknown, by compiler " __VERSION__ : identity;
}

}  // namespace

Versions versions() {
  utsname system{};
  uname(&system);
  static const std::string ours = build();
  return {VISCOBAR_VERSION,
          ours,
          SUNDIALS_VERSION,
          fmt::format("{}.{}.{}", H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE),
          fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION),
          fmt::format("{} {} {}, compiler {}, compiled for {}", system.sysname, system.release, system.machine,
                      __VERSION__, VISCOBAR_LEVEL)};
}

}  // namespace viscobar
