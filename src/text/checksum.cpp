#include "text/checksum.hpp"

#include <fmt/format.h>
#include <lzma.h>

namespace viscobar {

namespace {

// Polynomials over GF(2) modulo that of ECMA-182, the coefficient of x^0 in the highest bit.
using Polynomial = std::uint64_t;
constexpr Polynomial modulus = 0xC96C5795D7870F42, x_to_0 = Polynomial{1} << 63;

constexpr Polynomial times_x(Polynomial a) { return a & 1 ? a >> 1 ^ modulus : a >> 1; }

constexpr Polynomial product(Polynomial a, Polynomial b) {
  Polynomial sum = 0;
  for (; a != 0; a <<= 1, b = times_x(b))
    if (a & x_to_0) sum ^= b;
  return sum;
}

// The register after so many zero bytes: its product with x^(8 count).
constexpr Polynomial behind_zeros(Polynomial state, std::uint64_t count) {
  for (Polynomial power = x_to_0 >> 8; count != 0; count >>= 1, power = product(power, power))
    if (count & 1) state = product(state, power);
  return state;
}

}  // namespace

void Checksum::add(std::string_view next) {
  bytes += next.size();
  crc64 = lzma_crc64(reinterpret_cast<const std::uint8_t*>(next.data()), next.size(), crc64);
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

}  // namespace viscobar
