#pragma once

#include <string>
#include <vector>

#include "text/table.hpp"
#include "viscobar/studies/compare/compare.hpp"

namespace viscobar {

/// What each method ran on, what it cost and where it ended.
Table method_table(const Comparison& check, NumberText number);
/// Each method against the reference.
Table difference_table(const Comparison& check, NumberText number);
/// Contact periods of the reference and, matched with them, of each other method.
Table contact_table(const Comparison& check, NumberText number);

/// What a reader must know to judge the differences: methods left out, steps chosen, masses that are not the same.
std::vector<std::string> remarks(const MethodChoice& choice, const Comparison& check);

/// left, right or span:<mesh node>
std::string place(const ContactPeriod& period);

}  // namespace viscobar
