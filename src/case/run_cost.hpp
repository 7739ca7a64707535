#pragma once

#include "viscobar/case/case.hpp"

namespace viscobar {

/// About how long a sound setup takes, in seconds: start + steps (a + b nodes). Decides which of several cases to begin
/// with. docs/internals/sweep-balance.md has the formulas, their errors and the machine.
double estimated_seconds(const Setup& setup);

/// Memory of a run that grows with its size, in vectors with an entry for each unknown node, and with the list of its
/// output times; accurate to about a third.
struct MemoryNeed {
  double vectors = 0.0;  ///< with an entry an unknown node
  double bytes = 0.0;    ///< of these and of the output times
};

/// Memory that a case with sound values needs. Nothing is allocated.
MemoryNeed memory_need(const Case& run);

/// Bytes that this process can have: the memory of the machine, or less where a limit is set for the process
/// (`ulimit -v`) or its group (Linux, /sys/fs/cgroup/memory.max).
double memory_limit();

}  // namespace viscobar
