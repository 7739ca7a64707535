#include "report/plot/png.hpp"

#include <zlib.h>

#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <cassert>
#include <new>
#include <string_view>

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
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, MAX_WBITS, MAX_MEM_LEVEL, Z_RLE) != Z_OK) throw std::bad_alloc();
  std::string out(deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);  // there is room for all of it
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

}  // namespace

std::string base64(std::string_view bytes) {
  using namespace boost::archive::iterators;
  using Digits = base64_from_binary<transform_width<const char*, 6, 8>>;
  std::string out(Digits(bytes.data()), Digits(bytes.data() + bytes.size()));
  out.append((3 - bytes.size() % 3) % 3, '=');
  return out;
}

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
    rows += row == 0 ? '\0' : '\2';  // as it is; as the difference from the row above
    for (std::size_t i = row * width; i < (row + 1) * width; ++i)
      rows += static_cast<char>(row == 0 ? pixels[i] : pixels[i] - pixels[i - width]);
  }
  std::string png = "\x89PNG\r\n\x1a\n";
  put_chunk(png, "IHDR", header);
  put_chunk(png, "PLTE", colours);
  put_chunk(png, "IDAT", compressed(rows));
  put_chunk(png, "IEND", {});
  return "data:image/png;base64," + base64(png);
}

}  // namespace viscobar::plot
