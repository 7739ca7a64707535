#pragma once

#include <string>

#include "io/report_data.hpp"
#include "io/summary.hpp"

namespace viscobar {

/// report.html: one page that needs no other file and no network, with the pictures that the scene gives rise to.
std::string report_html(const Case& run, const BarSystem& system, const Outcome& outcome, const ContactSummary& contact,
                        const ReportData& data);

/// The pictures of a report, each a <figure> with its caption.
std::string displacement_map(const Case& run, const ReportData& data);
std::string profiles(const Case& run, const ReportData& data);
std::string end_traces(const Case& run, const Outcome& outcome, const ContactSummary& contact, const ReportData& data);
std::string reactions(const Case& run, const ContactSummary& contact, const ReportData& data);
std::string energies(const ReportData& data);

}  // namespace viscobar
