#pragma once

#include <ctime>

namespace viscobar {

/// Processor time of all threads together: wall-clock time depends on other load of the machine.
double seconds_of(auto&& work) {
  const std::clock_t began = std::clock();
  work();
  return static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
}

}  // namespace viscobar
