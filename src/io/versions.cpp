#include "viscobar/io/versions.hpp"

#include <fmt/format.h>
#include <hdf5.h>
#include <sundials/sundials_config.h>
#include <sys/utsname.h>

#include <Eigen/Core>

namespace viscobar {

Versions versions() {
  utsname system{};
  uname(&system);
  return {VISCOBAR_VERSION, SUNDIALS_VERSION, fmt::format("{}.{}.{}", H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE),
          fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION),
          fmt::format("{} {} {}, compiler {}", system.sysname, system.release, system.machine, __VERSION__)};
}

}  // namespace viscobar
