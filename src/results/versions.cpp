#include "viscobar/results/versions.hpp"

#include <elf.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <link.h>
#include <sundials/sundials_config.h>
#include <sys/utsname.h>

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

namespace viscobar {

namespace {

// The object that holds our code, and the identity that the linker has given it (ld --build-id).
struct Wanted {
  std::uintptr_t code;
  std::string build;
};

bool holds(const dl_phdr_info& object, std::uintptr_t code) {
  for (const ElfW(Phdr) & part : std::span(object.dlpi_phdr, object.dlpi_phnum))
    if (part.p_type == PT_LOAD && code - (object.dlpi_addr + part.p_vaddr) < part.p_memsz) return true;
  return false;
}

int look(dl_phdr_info* object, std::size_t, void* data) {
  Wanted& wanted = *static_cast<Wanted*>(data);
  if (!holds(*object, wanted.code)) return 0;
  for (const ElfW(Phdr) & part : std::span(object->dlpi_phdr, object->dlpi_phnum)) {
    if (part.p_type != PT_NOTE) continue;
    const char* at = reinterpret_cast<const char*>(object->dlpi_addr + part.p_vaddr);
    const auto padded = [](std::size_t bytes) { return (bytes + 3) / 4 * 4; };
    for (const char* const end = at + part.p_memsz; at + sizeof(ElfW(Nhdr)) <= end;) {
      ElfW(Nhdr) note{};
      std::memcpy(&note, at, sizeof note);
      const char *const name = at + sizeof note, *const value = name + padded(note.n_namesz);
      if (note.n_type == NT_GNU_BUILD_ID && std::string_view(name, note.n_namesz) == std::string_view("GNU\0", 4))
        for (std::size_t i = 0; i < note.n_descsz; ++i)
          wanted.build += fmt::format("{:02x}", static_cast<unsigned char>(value[i]));
      at = value + padded(note.n_descsz);
    }
  }
  return 1;
}

std::string build() {
  Wanted wanted{reinterpret_cast<std::uintptr_t>(&look), ""};
  dl_iterate_phdr(look, &wanted);
  return wanted.build.empty() ? "unknown, by compiler " __VERSION__ : wanted.build;
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
          fmt::format("{} {} {}, compiler {}", system.sysname, system.release, system.machine, __VERSION__)};
}

}  // namespace viscobar
