#pragma once

#include <cstddef>
#include <vector>

#include "viscobar/studies/precision/precision.hpp"

namespace viscobar::precision {

/// A row to be, and the case that it is of.
struct Timed {
  Case run;
  PrecisionRow row;
};

/// The tolerances or steps of a method on its mesh, the coarsest first.
std::vector<Timed> settings_of(const PrecisionStudy& study, const Case& run);

/// What all timed runs took together, by the clock on the wall and of the processor.
struct Spent {
  double wall = 0.0, processor = 0.0;
};

/// Times the rows one by one, until they take too long: then the others are left out.
Spent time_rows(const PrecisionStudy& study, std::vector<Timed>& rows, std::vector<PrecisionResult::LeftOut>& left_out);

}  // namespace viscobar::precision
