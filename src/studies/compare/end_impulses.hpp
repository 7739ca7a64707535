#pragma once

#include <vector>

#include "viscobar/case/case.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/studies/compare/difference.hpp"

namespace viscobar {

/// EndImpulse at each time of a recording.
class EndImpulses {
 public:
  EndImpulses(const Case& run, const Recording& recording);  ///< of what the case gave

  /// Over a contact period at an end, taken from the output time before it to the one after it; 0 under a span.
  double over(const ContactPeriod& period) const;

 private:
  const std::vector<double>& times_;
  double blur_;
  std::vector<double> left_, right_;
};

}  // namespace viscobar
