#include "report/plot/png.hpp"

#include <algorithm>
#include <cassert>
#include <string_view>

#include "report/plot/base64.hpp"

namespace viscobar::plot {

namespace {

void put(std::string& out, std::uint32_t value) {
  for (const unsigned shift : {24U, 16U, 8U, 0U}) out += static_cast<char>(value >> shift & 0xff);
}

std::uint32_t crc32(std::string_view bytes) {
  static const auto table = [] {
    std::array<std::uint32_t, 256> rows{};
    for (std::uint32_t i = 0; i < rows.size(); ++i) {
      std::uint32_t row = i;
      for (int bit = 0; bit < 8; ++bit) row = (row & 1) ? row >> 1 ^ 0xedb88320U : row >> 1;
      rows[i] = row;
    }
    return rows;
  }();
  std::uint32_t crc = ~0U;
  for (const char byte : bytes) crc = crc >> 8 ^ table[(crc ^ static_cast<unsigned char>(byte)) & 0xff];
  return ~crc;
}

std::uint32_t adler32(std::string_view bytes) {
  std::uint32_t sum = 1, sum_of_sums = 0;
  for (const char byte : bytes) {
    sum = (sum + static_cast<unsigned char>(byte)) % 65521;
    sum_of_sums = (sum_of_sums + sum) % 65521;
  }
  return sum_of_sums << 16 | sum;
}

void put_chunk(std::string& out, std::string_view type, std::string_view content) {
  put(out, static_cast<std::uint32_t>(content.size()));
  const std::size_t begin = out.size();
  out += type;
  out += content;
  put(out, crc32(std::string_view(out).substr(begin)));
}

// A zlib stream of stored blocks.
std::string stored(std::string_view bytes) {
  constexpr std::size_t longest = 0xffff;
  std::string out = "\x78\x01";
  const std::uint32_t check = adler32(bytes);
  do {
    const std::string_view block = bytes.substr(0, longest);
    bytes.remove_prefix(block.size());
    const auto size = static_cast<unsigned>(block.size());
    out += bytes.empty() ? '\x01' : '\x00';
    for (const unsigned word : {size, ~size}) {
      out += static_cast<char>(word & 0xff);
      out += static_cast<char>(word >> 8 & 0xff);
    }
    out += block;
  } while (!bytes.empty());
  put(out, check);
  return out;
}

}  // namespace

std::string png_data_uri(std::size_t width, std::size_t height, std::span<const Colour, 256> palette,
                         std::span<const std::uint8_t> pixels) {
  assert(pixels.size() == width * height);
  std::string header, colours, rows;
  put(header, static_cast<std::uint32_t>(width));
  put(header, static_cast<std::uint32_t>(height));
  header += std::string_view("\x08\x03\x00\x00\x00", 5);  // 8 bits, palette
  for (const Colour colour : palette)
    for (const unsigned shift : {16U, 8U, 0U}) colours += static_cast<char>(colour >> shift & 0xff);
  rows.reserve((width + 1) * height);
  for (std::size_t row = 0; row < height; ++row) {
    rows += '\0';  // no filter
    rows.append(reinterpret_cast<const char*>(pixels.data() + row * width), width);
  }
  std::string png = "\x89PNG\r\n\x1a\n";
  put_chunk(png, "IHDR", header);
  put_chunk(png, "PLTE", colours);
  put_chunk(png, "IDAT", stored(rows));
  put_chunk(png, "IEND", {});
  return "data:image/png;base64," + base64(png);
}

}  // namespace viscobar::plot
