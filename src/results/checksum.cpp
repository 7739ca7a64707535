#include "results/checksum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <vector>

#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

// Polynomials over GF(2) modulo that of ECMA-182, the coefficient of x^0 in the highest bit.
using Polynomial = std::uint64_t;
constexpr Polynomial modulus = 0xC96C5795D7870F42, one = Polynomial{1} << 63;

constexpr Polynomial times_x(Polynomial a) { return a & 1 ? a >> 1 ^ modulus : a >> 1; }

constexpr Polynomial product(Polynomial a, Polynomial b) {
  Polynomial sum = 0;
  for (; a != 0; a <<= 1, b = times_x(b))
    if (a & one) sum ^= b;
  return sum;
}

// The register after so many zero bytes: its product with x^(8 count).
constexpr Polynomial behind_zeros(Polynomial state, std::uint64_t count) {
  for (Polynomial power = one >> 8; count != 0; count >>= 1, power = product(power, power))
    if (count & 1) state = product(state, power);
  return state;
}

// tables[k][b] is what byte b becomes by k + 1 bytes: eight are taken in at a time.
constexpr auto tables = [] {
  std::array<std::array<Polynomial, 256>, 8> made{};
  for (std::size_t b = 0; b < 256; ++b) {
    Polynomial state = b;
    for (std::array<Polynomial, 256>& table : made) {
      for (int bit = 0; bit < 8; ++bit) state = times_x(state);
      table[b] = state;
    }
  }
  return made;
}();

Polynomial behind_eight(Polynomial state, const char* bytes) {
  static_assert(std::endian::native == std::endian::little);
  std::uint64_t next = 0;
  std::memcpy(&next, bytes, sizeof next);
  next ^= state;
  state = 0;
  for (std::size_t k = 0; k < 8; ++k) state ^= tables[7 - k][next >> 8 * k & 0xFF];
  return state;
}

// Four stretches side by side, none of which waits for another: twice as fast as one.
constexpr std::size_t stretch = 8192;
constexpr Polynomial over_stretch = behind_zeros(one, stretch);

Polynomial behind_stretches(Polynomial state, const char* bytes) {
  std::array<Polynomial, 4> states = {state, 0, 0, 0};
  for (std::size_t i = 0; i < stretch; i += 8)
    for (std::size_t s = 0; s < 4; ++s) states[s] = behind_eight(states[s], bytes + s * stretch + i);
  Polynomial joined = states[0];
  for (std::size_t s = 1; s < 4; ++s) joined = product(joined, over_stretch) ^ states[s];
  return joined;
}

Polynomial behind(Polynomial state, std::string_view bytes) {
  const char* at = bytes.data();
  const char* const end = at + bytes.size();
  for (; end - at >= static_cast<std::ptrdiff_t>(4 * stretch); at += 4 * stretch) state = behind_stretches(state, at);
  for (; end - at >= 8; at += 8) state = behind_eight(state, at);
  for (; at != end; ++at) state = tables[0][(state ^ static_cast<unsigned char>(*at)) & 0xFF] ^ state >> 8;
  return state;
}

}  // namespace

void Checksum::add(std::string_view next) {
  bytes += next.size();
  crc64 = ~behind(~crc64, next);
}

void Checksum::append(const Checksum& next) {
  bytes += next.bytes;
  crc64 = behind_zeros(crc64, next.bytes) ^ next.crc64;
}

Checksum Checksum::of(std::string_view bytes) {
  Checksum sum;
  sum.add(bytes);
  return sum;
}

Checksum Checksum::of_zeros(std::uint64_t count) { return {count, ~behind_zeros(~std::uint64_t{0}, count)}; }

std::string Checksum::digits() const { return fmt::format("{:016x}", crc64); }

Checksum checksum_of_file(const std::filesystem::path& file, std::uint64_t begin, std::uint64_t length) {
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(begin));
  Checksum sum;
  std::vector<char> block(1 << 18);
  while (stream && sum.bytes < length) {
    stream.read(block.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(block.size(), length - sum.bytes)));
    sum.add({block.data(), static_cast<std::size_t>(stream.gcount())});
  }
  if (stream.bad() || (!stream && !stream.eof()))
    throw IoError(file, "cannot be read: " + std::generic_category().message(errno));
  return sum;
}

}  // namespace viscobar
