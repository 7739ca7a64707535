#include "text/checksum.hpp"

#include <gtest/gtest.h>

#include <boost/crc.hpp>
#include <random>

#include "results/output_file.hpp"
#include "support/scratch.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar::testing_checksum {
namespace {

// Check value in the definition of CRC-64/XZ.
TEST(Checksum, OfTheCheckStringIsThatOfItsDefinition) {
  EXPECT_EQ(Checksum::of("123456789"), (Checksum{9, 0x995DC9BBDF1939FA}));
  EXPECT_EQ(Checksum::of("123456789").digits(), "995dc9bbdf1939fa");
  EXPECT_EQ(Checksum::of(""), Checksum{});
}

std::string noise(std::size_t length) {
  std::mt19937_64 random(length);
  std::string bytes(length, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

std::uint64_t by_boost(std::string_view bytes) {
  constexpr std::uint64_t ones = ~std::uint64_t{0};
  boost::crc_optimal<64, 0x42F0E1EBA9EA3693, ones, ones, true, true> crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

TEST(Checksum, IsThatOfBoostForEveryLengthAndPlaceInMemory) {
  const std::string bytes = noise(300);
  for (std::size_t begin = 0; begin < 9; ++begin)
    for (std::size_t length = 0; begin + length <= bytes.size(); ++length) {
      const std::string_view part = std::string_view(bytes).substr(begin, length);
      ASSERT_EQ(Checksum::of(part).crc64, by_boost(part)) << begin << ' ' << length;
    }
  const std::string many = noise(200'000);
  for (const std::size_t length : {32'767u, 32'768u, 32'769u, 65'536u, 100'001u, 200'000u})
    EXPECT_EQ(Checksum::of(many.substr(0, length)).crc64, by_boost(many.substr(0, length))) << length;
}

TEST(Checksum, OfPartsIsThatOfTheWhole) {
  const std::string bytes = noise(1000);
  const std::string_view all = bytes;
  for (std::size_t cut = 0; cut <= bytes.size(); cut += 37) {
    Checksum grown = Checksum::of(all.substr(0, cut)), joined = grown;
    grown.add(all.substr(cut));
    joined.append(Checksum::of(all.substr(cut)));
    EXPECT_EQ(grown, Checksum::of(all));
    EXPECT_EQ(joined, Checksum::of(all));
  }
}

TEST(Checksum, OfZerosIsThatOfTheirBytes) {
  for (const std::size_t count : {0u, 1u, 7u, 8u, 1000u, 123'456u})
    EXPECT_EQ(Checksum::of_zeros(count), Checksum::of(std::string(count, '\0'))) << count;
}

TEST(Checksum, OfAFileIsThatOfItsBytesOrOfAsManyAsThereAre) {
  const Scratch scratch;
  const std::string bytes = noise(300'000);
  std::ofstream(scratch / "file") << bytes;
  EXPECT_EQ(checksum_of_file(scratch / "file"), Checksum::of(bytes));
  EXPECT_EQ(checksum_of_file(scratch / "file", 10, 270'000), Checksum::of(bytes.substr(10, 270'000)));
  EXPECT_EQ(checksum_of_file(scratch / "file", 299'000, 2000), Checksum::of(bytes.substr(299'000)));
  EXPECT_EQ(checksum_of_file(scratch / "file", 300'000), Checksum{});
  EXPECT_THROW(checksum_of_file(scratch / "nowhere"), IoError);
  EXPECT_THROW(checksum_of_file(scratch.path()), IoError);
}

}  // namespace
}  // namespace viscobar::testing_checksum
