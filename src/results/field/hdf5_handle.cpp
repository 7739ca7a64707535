#include "results/field/hdf5_handle.hpp"

#include <sys/mman.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <new>
#include <string_view>
#include <system_error>

namespace viscobar {

namespace {
std::atomic<bool> failed = false;
}

bool hdf5_failed() { return failed; }
void set_hdf5_failed() { failed = true; }

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
  // A process may go on after a failure, as one of Python does.
  [[maybe_unused]] static const herr_t once = H5dont_atexit();
}

Hdf5File hdf5_file(const std::filesystem::path& path, unsigned access, hid_t properties) {
  begin_hdf5();
  return Hdf5File(hdf5_checked(path, "cannot be opened", [&] { return H5Fopen(path.c_str(), access, properties); }));
}

Hdf5Dataset hdf5_dataset(const std::filesystem::path& path, const Hdf5File& file, const std::string& name,
                         const char* lacking) {
  return Hdf5Dataset(hdf5_checked(path, lacking, [&] { return H5Dopen2(file.get(), name.c_str(), H5P_DEFAULT); }));
}

Hdf5Dataset new_dataset(const std::filesystem::path& path, const Hdf5File& file, const std::string& name, hid_t type,
                        std::span<const hsize_t> extent, hid_t properties) {
  std::vector<hsize_t> largest(extent.begin(), extent.end());
  if (extent[0] == 0) largest[0] = H5S_UNLIMITED;
  Hdf5Dataspace space;
  Hdf5Properties link, creation;
  return Hdf5Dataset(hdf5_checked(path, "cannot create a dataset", [&] {
    space.reset(
        H5Screate_simple(static_cast<int>(extent.size()), extent.data(), extent[0] == 0 ? largest.data() : nullptr));
    link.reset(H5Pcreate(H5P_LINK_CREATE));
    H5Pset_create_intermediate_group(link.get(), 1);
    // Without the times of its making the same values are the same bytes.
    creation.reset(properties == H5P_DEFAULT ? H5Pcreate(H5P_DATASET_CREATE) : H5Pcopy(properties));
    H5Pset_obj_track_times(creation.get(), false);
    return H5Dcreate2(file.get(), name.c_str(), type, space.get(), link.get(), creation.get(), H5P_DEFAULT);
  }));
}

void read_values(const std::filesystem::path& path, const Hdf5Dataset& dataset, hid_t type, void* values) {
  hdf5_checked(path, "cannot be read",
               [&] { return H5Dread(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values); });
}

Hdf5Rows::Hdf5Rows(const Hdf5Dataset& dataset, hsize_t first, hsize_t rows, hsize_t row_values)
    : file(H5Dget_space(dataset.get())) {
  const std::array<hsize_t, 2> begin{first, 0}, count{rows, row_values};
  memory.reset(H5Screate_simple(H5Sget_simple_extent_ndims(file.get()), count.data(), nullptr));
  H5Sselect_hyperslab(file.get(), H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr);
}

}  // namespace viscobar
