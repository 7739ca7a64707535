#include "report/plot/png.hpp"

#include <zlib.h>

#include <algorithm>
#include <cassert>
#include <new>

namespace viscobar::plot {

namespace {

void put(std::string& out, std::uint32_t value) {
  for (const unsigned shift : {24U, 16U, 8U, 0U}) out += static_cast<char>(value >> shift & 0xff);
}

void put_chunk(std::string& out, std::string_view type, std::string_view content) {
  put(out, static_cast<std::uint32_t>(content.size()));
  const std::size_t begin = out.size();
  out += type;
  out += content;
  const auto* bytes = reinterpret_cast<const Bytef*>(out.data());
  put(out, static_cast<std::uint32_t>(crc32_z(0, bytes + begin, out.size() - begin)));
}

// A zlib stream. Rows of differences are runs of equal bytes for the most part: to look for no other repetition takes a
// fifth of the time and makes no larger a picture than to look for all of them.
std::string compressed(std::string_view bytes) {
  constexpr int usual_memory = 8;
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, MAX_WBITS, usual_memory, Z_RLE) != Z_OK) throw std::bad_alloc();
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  std::string out;
  std::array<char, 8192> block;
  do {
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = static_cast<uInt>(block.size());
    deflate(&stream, Z_FINISH);
    out.append(block.data(), block.size() - stream.avail_out);
  } while (stream.avail_out == 0);
  deflateEnd(&stream);
  return out;
}

}  // namespace

std::string base64(std::string_view bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out((bytes.size() + 2) / 3 * 4, '=');
  auto next = out.begin();
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t given = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < given; ++k)
      three |= std::uint32_t{static_cast<std::uint8_t>(bytes[i + k])} << (16 - 8 * k);
    for (std::size_t k = 0; k <= given; ++k) next[static_cast<std::ptrdiff_t>(k)] = digits[three >> (18 - 6 * k) & 63];
    next += 4;
  }
  return out;
}

std::string png_data_uri(std::size_t width, std::size_t height, std::span<const Colour, 256> palette,
                         std::span<const std::uint8_t> pixels) {
  assert(pixels.size() == width * height);
  std::string header, colours, rows((width + 1) * height, '\2');  // 2: the row is the difference from the one above
  put(header, static_cast<std::uint32_t>(width));
  put(header, static_cast<std::uint32_t>(height));
  header += std::string_view("\x08\x03\x00\x00\x00", 5);  // 8 bits, palette
  for (const Colour colour : palette)
    for (const unsigned shift : {16U, 8U, 0U}) colours += static_cast<char>(colour >> shift & 0xff);
  rows[0] = '\0';  // the first row as it is
  std::copy_n(pixels.begin(), width, rows.begin() + 1);
  for (std::size_t row = 1; row < height; ++row)
    std::transform(pixels.begin() + row * width, pixels.begin() + (row + 1) * width, pixels.begin() + (row - 1) * width,
                   rows.begin() + row * (width + 1) + 1,
                   [](int here, int above) { return static_cast<char>(here - above); });
  std::string png = "\x89PNG\r\n\x1a\n";
  put_chunk(png, "IHDR", header);
  put_chunk(png, "PLTE", colours);
  put_chunk(png, "IDAT", compressed(rows));
  put_chunk(png, "IEND", {});
  return "data:image/png;base64," + base64(png);
}

}  // namespace viscobar::plot
