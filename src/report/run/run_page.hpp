#pragma once

#include "report/page.hpp"
#include "report/run/field_map.hpp"
#include "report/run/run_data.hpp"
#include "report/run/run_script_data.hpp"
#include "viscobar/results/outcome.hpp"

namespace viscobar {

/// The page report.html, with the pictures that the scene gives rise to.
Page report_page(const Case& run, const BarSystem& system, const Outcome& outcome, const ReportData& data);

/// A line of a picture over time, as points of the run's data.
struct TimeLine {
  std::vector<plot::Point> points;
  plot::Style style;
  std::string_view name;
};
/// Lines over the time of the run, with zero in view.
plot::Figure over_time(const Case& run, const ReportData& data, const std::string& axis, double height,
                       const std::vector<TimeLine>& lines);

FieldColours field_colours(const Case& run, const ReportData& data);

/// The pictures of a report.
Picture displacement_map(const Case& run, const ReportData& data, const FieldColours& colours);
Picture profiles(const Case& run, const ReportData& data);
Picture end_traces(const Case& run, const Outcome& outcome, const ReportData& data);
Picture reactions(const Case& run, const ReportData& data);
Picture energies(const Case& run, const ReportData& data);
Picture sensitivities(const Case& run, const ReportData& data);
FieldColours stress_colours(const Case& run, const ReportData& data);
Picture stress_map(const Case& run, const ReportData& data, const FieldColours& colours);
Picture end_tractions(const Case& run, const ReportData& data);
/// The points x + s u, s being axial_magnification(), in the colours of the stress, between the walls of the ends.
Picture axial_bar(const Case& run, const ReportData& data, const FieldColours& colours);
/// By how much displacements are drawn larger along the bar: 1, 2 or 5 times a power of ten.
double axial_magnification(const Case& run, const ReportData& data);

}  // namespace viscobar
