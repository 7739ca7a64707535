#pragma once

#include <string>

#include "results/checkpoint_file.hpp"

namespace viscobar {

/// A checkpoint with something in each of its parts.
inline RunCheckpoint example_checkpoint(double time = 0.5) {
  RunCheckpoint checkpoint;
  checkpoint.description = R"({"title": "a bar"})";
  checkpoint.schedule = CheckpointEvery{CheckpointEvery::Clock::wall, 30.0};
  Statistics statistics;
  statistics.steps = 77;
  statistics.energy = EnergyAccount{1.0, 0.0, 0.25, 0.0};
  checkpoint.motion = Checkpoint{time, 6, statistics, std::string(300, 'y')};
  checkpoint.files.tables[0] = Checksum{120, 1};
  checkpoint.files.tables[1] = Checksum{40, 2};
  checkpoint.files.field = FieldMark{6, 4096, {{800, 1000, {900, 3}}, {2000, 96, {96, 4}}}, std::string(300, 'o')};
  checkpoint.collected = std::string(50, 'c');
  checkpoint.times = {0.25, time};
  checkpoint.wall_seconds = 61.0;
  return checkpoint;
}

}  // namespace viscobar
