#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "text/table.hpp"
#include "viscobar/studies/precision/precision.hpp"

namespace viscobar {

/// What to pay for: which part dominates, and from which tolerance (or step) and epsilon on nothing is gained.
std::string advice(const PrecisionResult& result, const ErrorParts& parts, NumberText number);

/// Advice for the methods on a mesh, those named together that get the same.
struct Advice {
  std::string methods, text;
};
std::vector<Advice> advice_on_mesh(const PrecisionResult& result, std::size_t elements, NumberText number);

}  // namespace viscobar
