// The bytes of a checkpoint: whatever happens to them is noticed.
#include <gtest/gtest.h>

#include <random>

#include "checkpoint/example.hpp"
#include "support/file_size_limit.hpp"
#include "support/scratch.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar::testing_file {
namespace {

namespace fs = std::filesystem;

TEST(CheckpointBytes, GiveBackWhatTheyWereMadeOf) {
  const std::string bytes = encoded(example_checkpoint());
  const RunCheckpoint read = decoded(bytes);
  EXPECT_EQ(read.description, example_checkpoint().description);
  EXPECT_EQ(read.schedule->interval, 30.0);
  EXPECT_EQ(read.motion->statistics.energy->dissipated, 0.25);
  EXPECT_EQ(read.files.field->regions[1].begin, 2000u);
  EXPECT_EQ(encoded(read), bytes);
  RunCheckpoint beginning;
  beginning.description = "{}";
  EXPECT_FALSE(decoded(encoded(beginning)).motion);
}

TEST(CheckpointBytes, EveryTruncationIsNoticed) {
  const std::string bytes = encoded(example_checkpoint());
  for (std::size_t length = 0; length < bytes.size(); ++length)
    EXPECT_THROW(decoded(std::string_view(bytes).substr(0, length)), ArchiveError) << length;
  EXPECT_THROW(decoded(bytes + '\0'), ArchiveError);
}

TEST(CheckpointBytes, EveryFlippedBitIsNoticed) {
  std::string bytes = encoded(example_checkpoint());
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<char>(1 << bit % 8);
    EXPECT_THROW(decoded(bytes), ArchiveError) << bit;
    bytes[bit / 8] ^= static_cast<char>(1 << bit % 8);
  }
  EXPECT_NO_THROW(decoded(bytes));
}

// Two to twenty flips, stretches of zeros as a lost block leaves them, stretches of noise, parts left out or repeated.
TEST(CheckpointBytes, AThousandKindsOfDamageAreNoticed) {
  const std::string sound = encoded(example_checkpoint());
  std::mt19937_64 random(5);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  std::size_t damaged = 0;
  while (damaged < 1000) {
    std::string bytes = sound;
    const std::size_t at = below(bytes.size()), length = 1 + below(std::min<std::size_t>(512, bytes.size() - at));
    switch (below(5)) {
      case 0:
        for (std::size_t flips = 2 + below(19); flips > 0; --flips)
          bytes[below(bytes.size())] ^= static_cast<char>(1 << below(8));
        break;
      case 1: std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), length, '\0'); break;
      case 2:
        for (std::size_t i = at; i < at + length; ++i) bytes[i] = static_cast<char>(random());
        break;
      case 3: bytes.erase(at, length); break;
      default: bytes.insert(at, bytes.substr(at, length)); break;
    }
    if (bytes == sound) continue;
    ++damaged;
    EXPECT_THROW(decoded(bytes), ArchiveError);
  }
}

std::string archived(const RunCheckpoint& checkpoint) {
  ArchiveWriter archive;
  archive(checkpoint);
  return archive.take();
}

// Behind the checksum, too, nothing is believed: lengths of absurd size must not be allocated. Another number is read
// as what it is.
TEST(CheckpointBytes, AnArchiveOfNonsenseIsRefusedOrReadAsItStands) {
  std::mt19937_64 random(7);
  const std::string sound = archived(example_checkpoint());
  std::size_t refused = 0, taken = 0;
  for (std::size_t i = 0; i < 1000; ++i) {
    std::string bytes = sound;
    const std::uint64_t nonsense = random() >> random() % 64;
    std::memcpy(bytes.data() + random() % (bytes.size() - 8), &nonsense, 8);
    RunCheckpoint read;
    try {
      ArchiveReader reader(bytes);
      reader(read);
      if (!reader.finished()) continue;  // a shorter list, which decoded() refuses
      ++taken;
      RunCheckpoint again;
      ArchiveReader{archived(read)}(again);
      EXPECT_EQ(archived(again), archived(read));
    } catch (const ArchiveError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0u);
  EXPECT_GT(taken, 0u);
}

TEST(CheckpointFile, KeepsTheOneBefore) {
  const Scratch scratch;
  EXPECT_THROW(read_checkpoint(scratch.path()), std::invalid_argument);
  write_checkpoint(scratch.path(), example_checkpoint(0.25));
  write_checkpoint(scratch.path(), example_checkpoint(0.5));
  write_checkpoint(scratch.path(), example_checkpoint(0.75));
  EXPECT_EQ(read_checkpoint(scratch.path()).checkpoint.motion->time, 0.75);
  EXPECT_EQ(read_checkpoint(scratch.path()).complaint, "");
  fs::resize_file(scratch / "checkpoint.bin", 500);
  const FoundCheckpoint found = read_checkpoint(scratch.path());
  EXPECT_EQ(found.checkpoint.motion->time, 0.5);
  EXPECT_NE(found.complaint.find("checkpoint.bin: is truncated"), std::string::npos) << found.complaint;
  fs::resize_file(scratch / "checkpoint.previous.bin", 0);
  EXPECT_THROW(read_checkpoint(scratch.path()), IoError);
}

TEST(CheckpointFile, AKillBetweenTheTwoRenamesLeavesTheOneBefore) {
  const Scratch scratch;
  write_checkpoint(scratch.path(), example_checkpoint(0.25));
  fs::rename(scratch / "checkpoint.bin", scratch / "checkpoint.previous.bin");
  EXPECT_EQ(read_checkpoint(scratch.path()).checkpoint.motion->time, 0.25);
}

TEST(CheckpointFile, OneThatCannotBeWrittenLeavesTheOthersAlone) {
  const Scratch scratch;
  write_checkpoint(scratch.path(), example_checkpoint(0.25));
  write_checkpoint(scratch.path(), example_checkpoint(0.5));
  try {
    const FileSizeLimit full(100);
    write_checkpoint(scratch.path(), example_checkpoint(0.75));
    ADD_FAILURE() << "a full disk was not noticed";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("File too large"), std::string::npos) << error.what();
  }
  EXPECT_EQ(read_checkpoint(scratch.path()).checkpoint.motion->time, 0.5);
  fs::remove(scratch / "checkpoint.bin");
  EXPECT_EQ(read_checkpoint(scratch.path()).checkpoint.motion->time, 0.25);
}

TEST(CheckpointFile, WhatIsNoFileGivesWayToTheOneBefore) {
  const Scratch scratch;
  for (const char* inside : {"", "in the way"}) {
    write_checkpoint(scratch.path(), example_checkpoint(0.25));
    fs::rename(scratch / "checkpoint.bin", scratch / "checkpoint.previous.bin");
    fs::create_directories(scratch / "checkpoint.bin" / inside);
    const FoundCheckpoint found = read_checkpoint(scratch.path());
    EXPECT_EQ(found.checkpoint.motion->time, 0.25);
    EXPECT_NE(found.complaint.find("checkpoint.bin: is no regular file"), std::string::npos) << found.complaint;
    remove_newest_checkpoint(scratch.path());
    EXPECT_TRUE(fs::exists(scratch / "checkpoint.damaged" / inside));
    fs::remove_all(scratch / "checkpoint.damaged");
  }
}

TEST(CheckpointFile, AFailedRenameNamesTheFile) {
  const Scratch scratch;
  fs::create_directories(scratch / "checkpoint.bin/in the way");
  fs::create_directories(scratch / "checkpoint.previous.bin/in the way");
  try {
    write_checkpoint(scratch.path(), example_checkpoint());
    ADD_FAILURE() << "a directory was replaced";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("checkpoint.bin: cannot be replaced"), std::string::npos) << error.what();
  }
  EXPECT_TRUE(fs::exists(scratch / "checkpoint.bin/in the way"));
  EXPECT_FALSE(fs::exists(scratch / "checkpoint.bin.part"));
}

}  // namespace
}  // namespace viscobar::testing_file
