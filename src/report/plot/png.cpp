#include "report/plot/png.hpp"

#include <zlib.h>

#include <cassert>
#include <new>
#include <string_view>

#include "report/plot/base64.hpp"

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

// A zlib stream.
std::string compressed(std::string_view bytes) {
  std::string out(compressBound(bytes.size()), '\0');
  uLongf size = out.size();
  if (compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
               bytes.size()) != Z_OK)
    throw std::bad_alloc();  // the only failure with room for the bound
  out.resize(size);
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
  put_chunk(png, "IDAT", compressed(rows));
  put_chunk(png, "IEND", {});
  return "data:image/png;base64," + base64(png);
}

}  // namespace viscobar::plot
