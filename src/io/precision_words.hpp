#pragma once

#include <span>
#include <string>
#include <vector>

#include "io/table.hpp"
#include "viscobar/analysis/work_precision.hpp"

namespace viscobar {

/// The rows that belong to a method on a mesh.
std::span<const PrecisionRow> rows_of(const PrecisionResult& result, const ErrorParts& parts);

/// space, penalty or time: the largest part of the row's error; empty where they are not known.
std::string largest_part(const PrecisionResult& result, const PrecisionRow& row);

Table precision_table(const PrecisionStudy& study, const PrecisionResult& result, NumberText number);

/// What to pay for: which part dominates, and from which tolerance (or step) and epsilon on nothing is gained.
std::string advice(const PrecisionStudy& study, const PrecisionResult& result, const ErrorParts& parts,
                   NumberText number);

/// What the errors are measured against, and how good that is.
std::string reference_sentence(const PrecisionResult& result, NumberText number);
Table time_reference_table(const PrecisionResult& result, NumberText number);
Table mesh_table(const PrecisionReference& reference, NumberText number);

/// What failed, what was left out, and what is not what it seems.
std::vector<std::string> remarks(const PrecisionStudy& study, const PrecisionResult& result);

}  // namespace viscobar
