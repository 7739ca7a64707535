#pragma once

#include <limits>
#include <string>

#include "report/plot/axis.hpp"
#include "report/plot/colour_map.hpp"
#include "report/run/run_data.hpp"
#include "results/summary.hpp"

namespace viscobar {

/// How displacements are coloured.
struct FieldColours {
  plot::ColourMap map;
  plot::Axis values;  ///< the ends of the scale
  /// Up to the one, and from the other on, a node touches the span obstacle.
  double contact_up_to = -std::numeric_limits<double>::infinity(), contact_from = -contact_up_to;
  static constexpr plot::Colour touching = 0xe0218a;
};

/// The displacement over space and time for the page's script: u = low + (high - low) q / 65535, q in row after row of
/// 16 bits, low byte first, as base64.
std::string field_json(const ReportData& data, const FieldColours& colours);

/// The contact changes that the page marks, as columns.
std::string events_json(const ReportData& data, std::size_t happened);

/// What holds the ends and the span: kind, gap, and the times in contact. An obstacle that moves has its surface at the
/// times of the field.
std::string supports_json(const Scene& scene, const Outcome& outcome, const ReportData& data);

}  // namespace viscobar
