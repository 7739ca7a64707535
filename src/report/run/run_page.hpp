#pragma once

#include "report/page.hpp"
#include "report/run/run_data.hpp"
#include "report/run/run_script_data.hpp"
#include "viscobar/results/outcome.hpp"

namespace viscobar {

/// The page report.html, with the pictures that the scene gives rise to.
Page report_page(const Case& run, const BarSystem& system, const Outcome& outcome, const ReportData& data);

FieldColours field_colours(const Case& run, const ReportData& data);

/// The pictures of a report.
Picture displacement_map(const Case& run, const ReportData& data, const FieldColours& colours);
Picture profiles(const Case& run, const ReportData& data);
Picture end_traces(const Case& run, const Outcome& outcome, const ReportData& data);
Picture reactions(const Case& run, const ReportData& data);
Picture energies(const ReportData& data);
Picture sensitivities(const Case& run, const ReportData& data);

}  // namespace viscobar
