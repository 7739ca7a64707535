#pragma once

#include <ctime>

namespace viscobar {

/// Of the processor, all threads together: the clock on the wall tells what else the machine does.
double seconds_of(auto&& work) {
  const std::clock_t began = std::clock();
  work();
  return static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
}

}  // namespace viscobar
