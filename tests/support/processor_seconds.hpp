#pragma once

#include <ctime>

namespace viscobar {

/// Processor time of all threads together: wall-clock time depends on other load of the machine.
inline double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Those of some work.
double seconds_of(auto&& work) {
  const double began = processor_seconds();
  work();
  return processor_seconds() - began;
}

}  // namespace viscobar
