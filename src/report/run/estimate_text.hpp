#pragma once

#include <string>
#include <utility>
#include <vector>

#include "viscobar/case/accuracy.hpp"

namespace viscobar {

/// The estimate of a run's error as rows of a terminal's table, name and value.
std::vector<std::pair<std::string, std::string>> estimate_rows(const ErrorEstimate& estimate);

/// The same as a section of a page, with the reasons and the runs that it cost.
std::string estimate_section(const ErrorEstimate& estimate);

/// Where there is none: why.
std::string no_estimate_section(const std::string& why);

}  // namespace viscobar
