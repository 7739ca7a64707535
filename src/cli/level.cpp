// Runs before main and before the initialisation of anything that is compiled for more than any x86-64 has.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

#ifdef __x86_64__
constexpr const char* levels[] = {"x86-64", "x86-64-v2", "x86-64-v3", "x86-64-v4"};

int number_of(const char* name) {
  for (int k = 0; k < 4; ++k)
    if (std::strcmp(levels[k], name) == 0) return k;
  return -1;
}

// The processor's level, or a lower one that the environment asks for.
int usable_level() {
  __builtin_cpu_init();
  int level = 0;
  if (__builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt")) level = 1;
  if (level == 1 && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
    level = 2;
  if (level == 2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    level = 3;
  if (const char* asked = std::getenv("VISCOBAR_LEVEL"))
    if (const int number = number_of(asked); number >= 0 && number < level) return number;
  return level;
}

// The process becomes the program of the highest level that is installed beside this one, LEVELS/x86-64-v3/viscobar.
[[gnu::constructor(101)]] void choose_level(int, char** arguments, char**) {
  const int own = number_of(VISCOBAR_LEVEL), usable = usable_level();
  if (own < 0) return;  // compiled for the very processor
  if (own > usable) {
    std::fprintf(stderr,
                 "viscobar was built for processors of the level %s, and this one has %s; build it here, or with "
                 "-DVISCOBAR_LEVEL=x86-64 for all\n",
                 levels[own], levels[usable]);
    std::_Exit(1);
  }
  char self[4000];
  const ssize_t length = ::readlink("/proc/self/exe", self, sizeof self - 1);
  if (length <= 0) return;
  self[length] = '\0';
  char* const slash = std::strrchr(self, '/');
  *slash = '\0';
  for (int level = usable; level > own; --level) {
    char program[4200];
    std::snprintf(program, sizeof program, "%s/" VISCOBAR_LEVELS "/%s/%s", self, levels[level], slash + 1);
    ::execv(program, arguments);  // returns where there is none
  }
}
#endif

}  // namespace
