#pragma once

#include <limits>
#include <string>

#include "report/plot/colour_map.hpp"
#include "report/plot/figure.hpp"
#include "report/run/thinned_field.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// How the values of a field are coloured.
struct FieldColours {
  plot::ColourMap map;
  plot::Axis values;  ///< the ends of the scale
  /// Up to the one, and from the other on, a node touches the span obstacle.
  double contact_up_to = -std::numeric_limits<double>::infinity(), contact_from = -contact_up_to;
  static constexpr plot::Colour touching = 0xe0218a;
};

/// Of values of two signs by a scale whose pale middle is zero.
FieldColours colours_of(const ThinnedField& field, const std::string& label);

/// The time of a page's pictures.
plot::Axis time_axis(const ThinnedField& field, const Units& units);

/// A field over time, to the right, and space, upwards. `layer` is what the script draws.
plot::Figure map_figure(const Case& run, const ThinnedField& field, const FieldColours& colours,
                        const std::string& layer);

/// What a caption says of the scale, and of what the picture was drawn from: `what` are the values of a row.
std::string map_remark(const Case& run, const ThinnedField& field, const FieldColours& colours, const char* what);

/// Output times of the field at about `count` equal distances.
std::vector<std::size_t> rows_of_few_times(const ThinnedField& field, std::size_t count);

}  // namespace viscobar
