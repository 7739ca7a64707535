#include "results/npy_file.hpp"

#include <fmt/format.h>

#include <bit>
#include <string>

namespace viscobar {

static_assert(std::endian::native == std::endian::little, "the numbers are written as they lie in memory");

NpyFile::NpyFile(const std::filesystem::path& path, std::span<const std::size_t> shape) : file_(path) {
  // A tuple of one number ends with a comma.
  std::string head =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", fmt::join(shape, ", "));
  constexpr std::size_t before = 10, alignment = 64;
  head.resize((before + head.size() + 1 + alignment - 1) / alignment * alignment - before - 1, ' ');
  head += '\n';
  std::string start("\x93NUMPY\x01\x00", 8);
  start += static_cast<char>(head.size() & 0xff);
  start += static_cast<char>(head.size() >> 8);
  start += head;
  file_.write_at(0, start);
  written_ = start.size();
}

void NpyFile::append(std::span<const double> values) {
  const auto bytes = std::as_bytes(values);
  file_.write_at(written_, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  written_ += bytes.size();
}

}  // namespace viscobar
