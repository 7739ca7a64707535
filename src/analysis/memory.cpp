#include "viscobar/analysis/memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace viscobar {

MemoryNeed memory_need(const Case& run) {
  const Scene& scene = run.scene;
  const double n = static_cast<double>(run.elements) + 1.0 - is_fixed(scene.left) - is_fixed(scene.right);
  double vectors = 12.0;  // the system itself: mass with its factor, initial data, two fields for output
  switch (run.method) {
    // A vector of a multistep method has displacement and velocity: its history and some eight more.
    case MethodName::cvode: vectors += 2.0 * (scene.bar.viscosity > 0.0 ? 6.0 + 8.0 : 13.0 + 8.0); break;
    case MethodName::ida:
    case MethodName::rigid: vectors += 2.0 * (6.0 + 8.0); break;
    // The stages of a step and some eight more, and the step's two ends.
    case MethodName::arkode: vectors += 2.0 * (7.0 + 8.0) + 2.0 * 3.0; break;
    // The stages of a step, and the step's two ends. The dense matrices of rosenbrock4, on few nodes, do not count.
    case MethodName::odeint: vectors += 2.0 * 14.0 + 2.0 * 3.0; break;
    // Propagators of several sub-steps, dense over displacement and velocity.
    case MethodName::exponential: vectors += 4.0 * 4.0 * n; break;
    case MethodName::fully_discrete:
    case MethodName::finite_difference: break;
  }
  vectors += 8.0;  // the matrix and its factor, right-hand sides
  return {vectors, (vectors * n + run.end / run.output_every) * sizeof(double)};
}

double memory_limit() {
  double limit = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (rlimit own{}; ::getrlimit(RLIMIT_AS, &own) == 0 && own.rlim_cur != RLIM_INFINITY)
    limit = std::min(limit, static_cast<double>(own.rlim_cur));
  double of_group = 0.0;  // the file says "max" where there is none
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> of_group) limit = std::min(limit, of_group);
  return limit;
}

}  // namespace viscobar
