#include "case/memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "case/method_table.hpp"

namespace viscobar {

MemoryNeed memory_need(const Case& run) {
  const Scene& scene = run.scene;
  const double n = static_cast<double>(run.elements) + 1.0 - is_fixed(scene.left) - is_fixed(scene.right);
  double vectors = 12.0;  // the system itself: mass with its factor, initial data, two fields for output
  if (const auto own = method_row(run.method).vectors) vectors += own(run, n);
  vectors += 8.0;  // the matrix and its factor, right-hand sides
  return {vectors, (vectors * n + run.end / run.output_every) * sizeof(double)};
}

double memory_limit() {
  double limit = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (rlimit own{}; ::getrlimit(RLIMIT_AS, &own) == 0 && own.rlim_cur != RLIM_INFINITY)
    limit = std::min(limit, static_cast<double>(own.rlim_cur));
  static const double of_group = [] {
    double bytes = 0.0;  // the file says "max" where there is none
    return std::ifstream("/sys/fs/cgroup/memory.max") >> bytes ? bytes : std::numeric_limits<double>::infinity();
  }();
  return std::min(limit, of_group);
}

}  // namespace viscobar
