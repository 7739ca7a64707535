#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace viscobar {

/// Length and CRC-64/XZ of bytes. It finds every error within 64 neighbouring bits, any two flipped bits in up to 1 GB
/// (the order of its polynomial is 8,589,606,914 bits), and any other damage but for one in 2^64.
struct Checksum {
  std::uint64_t bytes = 0, crc64 = 0;

  /// Takes further bytes in, so that no bytes need to be there at once.
  void add(std::string_view next);
  /// Takes the bytes of another one in behind its own, without seeing them.
  void append(const Checksum& next);
  static Checksum of(std::string_view bytes);
  static Checksum of_zeros(std::uint64_t count);
  std::string digits() const;

  bool operator==(const Checksum&) const = default;
  static void members(auto& self, auto&& each) { each(self.bytes, self.crc64); }
};

}  // namespace viscobar
