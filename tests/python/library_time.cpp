// Processor seconds of one run of a scene by the C++ library, from its file to the numbers in memory: the least of N,
// as tests/python/overhead.py takes them. Usage: library_time SCENE N
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <viscobar/viscobar.hpp>

namespace {

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) return 2;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < std::atoi(arguments[2]); ++k) {
    const double begun = processor_seconds();
    const viscobar::SceneFile scene = viscobar::read_scene(arguments[1]);
    const viscobar::Recording recording = viscobar::record(scene.run);
    least = std::min(least, processor_seconds() - begun);
  }
  std::printf("%.9g\n", least);
}
