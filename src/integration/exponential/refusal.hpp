#pragma once

#include <array>
#include <optional>

#include "viscobar/scene/scene.hpp"

namespace viscobar::exponential {

/// Why exponential does not take ends that are given that: a stop whose law is not linear. Absent: it takes them.
inline std::optional<Finding> refusal(EndInput left, EndInput right) {
  for (EndInput* end : {&left, &right})
    if (end->stop && end->stop->linear()) end->stop.reset();
  return law_refusal("exponential", left, right);
}

}  // namespace viscobar::exponential
