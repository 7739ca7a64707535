#pragma once

#include <string>

#include "report/run/field_map.hpp"
#include "report/run/run_data.hpp"
#include "results/summary.hpp"

namespace viscobar {

/// A field over space and time for the page's script: its values are low + (high - low) q / 65535, q in row after row
/// of 16 bits, low byte first, as base64.
std::string field_json(const ThinnedField& field, const FieldColours& colours);

/// The contact changes that the page marks, as columns.
std::string events_json(const ReportData& data, std::size_t happened);

/// What holds the ends and the span: kind, gap, and the times in contact. An obstacle that moves has its surface at the
/// times of the field.
std::string supports_json(const Scene& scene, const Outcome& outcome, const ReportData& data);

}  // namespace viscobar
