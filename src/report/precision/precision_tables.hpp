#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "report/columns.hpp"
#include "report/page.hpp"
#include "text/table.hpp"
#include "viscobar/studies/precision/precision.hpp"

namespace viscobar {

std::span<const PrecisionRow> rows_of(const PrecisionResult& result, const ErrorParts& parts);

/// True if a reference can tell an error from its own.
bool resolved(double error, double reference_error);

/// tolerance or step
const char* setting_word(MethodName method);

/// The time error, absent also where its reference cannot tell it from its own error.
std::optional<double> resolved_time_error(const PrecisionResult& result, const PrecisionRow& row);

/// space, penalty or time: the largest part of the row's error; empty where they are not known or not told apart.
std::string largest_part(const PrecisionResult& result, const PrecisionRow& row);

/// The columns of precision.json and precision.csv, of which the table takes its own. They refer to the result.
std::vector<Column<PrecisionRow>> precision_columns(const PrecisionResult& result);
Table precision_table(const PrecisionResult& result, const NumberText& number);

/// The values of a member of the parts, each once, in the order of the rows.
template <class Value>
std::vector<Value> values_in(const PrecisionResult& result, Value ErrorParts::*member) {
  std::vector<Value> values;
  for (const ErrorParts& parts : result.parts)
    if (std::ranges::find(values, parts.*member) == values.end()) values.push_back(parts.*member);
  return values;
}
inline std::vector<std::size_t> meshes_in(const PrecisionResult& result) {
  return values_in(result, &ErrorParts::elements);
}

/// The reference of the errors, and its own error.
std::string reference_sentence(const PrecisionResult& result, const NumberText& number);
Table time_reference_table(const PrecisionResult& result, const NumberText& number);
Table mesh_table(const PrecisionReference& reference, const NumberText& number);
/// "step 0.01 s" or "tolerance 1e-06"
std::string setting_text(MethodName method, double setting, const NumberText& number);

std::vector<std::string> remarks(const PrecisionStudy& study, const PrecisionResult& result, const NumberText& number);

/// Advice on cost: which part dominates, and from which tolerance (or step) and epsilon on nothing is gained.
std::string advice(const PrecisionResult& result, const ErrorParts& parts, const NumberText& number);

/// Advice for the methods on a mesh, those named together that get the same.
struct Advice {
  std::string methods, text;
};
std::vector<Advice> advice_on_mesh(const PrecisionResult& result, std::size_t elements, const NumberText& number);

// The pictures of the page, on logarithmic axes; without panels where there is nothing to draw.
Picture error_picture(const PrecisionResult& result, const NumberText& number);
Picture time_error_picture(const PrecisionResult& result, const NumberText& number);
Picture parts_picture(const PrecisionResult& result, const NumberText& number);

}  // namespace viscobar
