// Bytes of a checkpoint. The first byte says what the others are: the file, its content, or damage (place, place,
// value) done to the file or to the content of an intact one; content is sealed with a checksum that fits. Any damage
// to a file is refused, and what is taken encodes to bytes that give it back.

// longest: 600
#include <cstdint>

#include "checkpoint/example.hpp"
#include "claim.hpp"

namespace viscobar {
namespace {

const std::string intact = encoded(example_checkpoint());

std::string content_of(const std::string& file) {
  const std::size_t around = sealed("").size() / 4;  // three numbers before, one after
  return file.substr(3 * around, file.size() - 4 * around);
}

std::string damaged(std::string bytes, const std::string& damage) {
  for (std::size_t i = 0; i + 2 < damage.size(); i += 3) {
    const auto high = static_cast<unsigned char>(damage[i]), low = static_cast<unsigned char>(damage[i + 1]);
    bytes[(high * 256u + low) % bytes.size()] = damage[i + 2];
  }
  return bytes;
}

// True if the bytes were taken.
bool read(const std::string& file) {
  try {
    const std::string again = encoded(decoded(file));
    fuzz::claim(encoded(decoded(again)) == again, "a checkpoint that is taken can be written and read again");
    return true;
  } catch (const ArchiveError& error) {
    fuzz::claim(error.what()[0] != '\0', "a refused checkpoint gets a reason");
    return false;
  }
}

}  // namespace
}  // namespace viscobar

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace viscobar;
  if (size == 0) return 0;
  const std::string input(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 4) {
    case 0: read(input); break;
    case 1: read(sealed(input)); break;
    case 2: read(sealed(damaged(content_of(intact), input))); break;
    default: {
      const std::string file = damaged(intact, input);
      fuzz::claim(read(file) == (file == intact), "damage is noticed, and nothing else");
    }
  }
  return 0;
}
