#pragma once

#include <cstddef>
#include <functional>

namespace viscobar {

/// Cores of the machine, looked up once: the system opens a file to tell.
std::size_t cores();

/// Calls work(0) ... work(count - 1) on all cores (or on `threads`), each once, in any order; results that are stored
/// by index do not depend on the number of threads. The first exception is rethrown when all have stopped.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& work, std::size_t threads = 0);

}  // namespace viscobar
