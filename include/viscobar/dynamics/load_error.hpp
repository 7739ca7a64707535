#pragma once

#include <stdexcept>
#include <string>

namespace viscobar {

/// A load that is not finite where it is needed.
class LoadError : public std::runtime_error {
 public:
  /// With the message and the time of the fault.
  LoadError(double at, const std::string& what) : std::runtime_error(what), time(at) {}
  double time;  ///< at which it is not finite
};

}  // namespace viscobar
