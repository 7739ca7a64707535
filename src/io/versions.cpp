#include "viscobar/io/versions.hpp"

#include <fmt/format.h>
#include <hdf5.h>
#include <sundials/sundials_config.h>
#include <sys/utsname.h>

#include <Eigen/Core>

namespace viscobar {

Versions versions() {
  unsigned major = 0, minor = 0, release = 0;
  H5get_libversion(&major, &minor, &release);
  utsname system{};
  uname(&system);
  return {VISCOBAR_VERSION, SUNDIALS_VERSION, fmt::format("{}.{}.{}", major, minor, release),
          fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION),
          fmt::format("{} {} {}, compiler {}", system.sysname, system.release, system.machine, __VERSION__)};
}

}  // namespace viscobar
