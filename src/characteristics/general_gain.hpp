#pragma once

#include <memory>

#include "characteristics/load_gain.hpp"
#include "characteristics/load_in_passages.hpp"

namespace viscobar::characteristics {

/// What waves gain from a load of which nothing is known but its values, in a run of so many passages.
std::unique_ptr<LoadGain> general_gain(const GeneralLoad& load, const Frame& frame, double passages);

}  // namespace viscobar::characteristics
