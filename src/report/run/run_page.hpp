#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "report/number_text.hpp"
#include "report/page.hpp"
#include "report/run/run_data.hpp"
#include "viscobar/results/outcome.hpp"

namespace viscobar {

/// The page report.html, with the pictures that the scene gives rise to.
Page report_page(const Setup& setup, const BarSystem& system, const Outcome& outcome, const ReportData& data);

/// Puts the time of the whole run into it, which its making is a part of.
void tell_whole_run(Page& page, double wall_seconds);

/// The estimate of a run's error as rows of a terminal's table, name and value.
std::vector<std::pair<std::string, std::string>> estimate_rows(const Scene& scene, const ErrorEstimate& estimate);

inline NumberText on_page(const Case& run) { return NumberText::page(run.scene); }

/// "h = 0.01 m", of unequal elements their mean and the smallest.
std::string element_size(const Mesh& mesh, const NumberText& number);

struct FieldColours {
  plot::ColourMap map;
  plot::Axis values;  ///< the ends of the scale
  plot::Range range;  ///< of the field
  /// Up to the one, and from the other on, a node touches the span obstacle.
  double contact_up_to = -std::numeric_limits<double>::infinity(), contact_from = -contact_up_to;
  static constexpr plot::Colour touching = 0xe0218a;
};

/// Colours of a field. Values of two signs have a scale whose pale middle is zero, and so have all that are `about` it.
FieldColours colours_of(const ThinnedField& field, const std::string& label, bool about_zero = false);

plot::Axis time_axis(const ThinnedField& field, const NumberText& number);

/// A field over time, to the right, and space, upwards; `symbol` is what its values are called.
plot::Figure map_figure(const Case& run, const ThinnedField& field, const FieldColours& colours,
                        std::string_view symbol);

/// Caption on the colour scale and on the data of the picture: `what` names the values of a row.
std::string map_remark(const Case& run, const ThinnedField& field, const FieldColours& colours, const char* what);

/// Output times of the field at about `count` equal distances.
std::vector<std::size_t> rows_of_few_times(const ThinnedField& field, std::size_t count);

struct TimeLine {
  std::vector<plot::Point> points;
  plot::Style style;
  std::string name;
};
/// A line of what is known at the output times, and of each contact at its closing, its peak and its opening.
std::vector<plot::Point> with_contacts(const std::vector<plot::Point>& line,
                                       const std::vector<plot::Interval>& contacts,
                                       const std::function<double(double t, double reaction)>& value);
/// Contacts of a place, up to the time that the run reached.
std::vector<plot::Interval> contacts_of(const ContactPlace& place, const Outcome& outcome, const ReportData& data);

/// Lines over the time of the run, with zero in view.
plot::Figure over_time(const Case& run, const ReportData& data, const std::string& axis, double height,
                       const std::vector<TimeLine>& lines);

FieldColours field_colours(const Case& run, const ReportData& data);
FieldColours stress_colours(const Case& run, const ReportData& data);

Picture displacement_map(const Case& run, const ReportData& data, const FieldColours& colours);
Picture profiles(const Case& run, const ReportData& data);
Picture end_traces(const Case& run, const Outcome& outcome, const ReportData& data);
Picture reactions(const Case& run, const Outcome& outcome, const ReportData& data);
/// Forces of joints that are not bonded.
Picture joint_forces(const Case& run, const Outcome& outcome, const ReportData& data);
Picture energies(const Case& run, const ReportData& data);
Picture gauges(const Case& run, const ReportData& data);
Picture sensitivities(const Case& run, const ReportData& data);
Picture stress_map(const Case& run, const BarSystem& system, const Outcome& outcome, const ReportData& data,
                   const FieldColours& colours);
Picture end_tractions(const Case& run, const BarSystem& system, const Outcome& outcome, const ReportData& data);
/// The points x + s u in the colours of the stress, between the walls of the ends.
Picture axial_bar(const Case& run, const ReportData& data, const FieldColours& colours);
/// Where the members of a chain, or a bar alone, are drawn along the axis: at x + magnification u + shift. Gaps of
/// joints, magnified alike, and rigid bodies, as blocks of some width, shift what is to the right of them.
struct AxialLayout {
  struct Place {
    bool rigid;
    double shift;
  };
  double magnification, block;  ///< 1, 2 or 5 times a power of ten; the width of a rigid body
  std::vector<Place> members{};

  double left_shift() const { return members.front().shift; }
  double right_shift() const { return members.back().shift + (members.back().rigid ? block : 0.0); }
};
AxialLayout axial_layout(const Case& run, const ReportData& data);

// For the page's script, as JSON.

/// A field over space and time: its values are low + (high - low) q / 65535, q in row after row of 16 bits, low byte
/// first, as base64.
std::string field_json(const ThinnedField& field, const FieldColours& colours);
/// The contact changes that the page marks, as columns.
std::string events_json(const ReportData& data, std::size_t happened);
/// Supports of the ends and the span: kind, gap, the times in contact, and of each contact the time of its largest
/// reaction and that. An obstacle that moves has its surface at the
/// times of the field.
std::string supports_json(const Scene& scene, const Outcome& outcome, const ReportData& data);
/// The layout of the bar along its axis: of each member its nodes and elements in the fields, and its shift; the joints
/// that are contacts with their times in contact.
std::string axial_json(const Case& run, const Outcome& outcome, const ReportData& data);
/// Names of the units that the scene names, by quantity.
std::string units_json(const Units& units);

}  // namespace viscobar
