#pragma once

#include <span>
#include <string>
#include <string_view>

#include "dynamics/gauge.hpp"
#include "run/contact_places.hpp"

namespace viscobar {

// Headers and rows of the tables of a run. Numbers are written in the shortest form that reads back as the same double.

/// ends.csv: a row per output time.
inline constexpr std::string_view ends_header = "t,u_left,v_left,reaction_left,u_right,v_right,reaction_right";
std::string ends_row(const Snapshot& at);

/// events.csv: a row per contact change.
inline constexpr std::string_view events_header = "t,where,change,velocity";
std::string events_row(const Event& event);

/// energy.csv: a row per output time that has an energy, with
///
///     kinetic + elastic + contact = total,   total + dissipated = total at the start + work + balance error
///
inline constexpr std::string_view energy_header = "t,kinetic,elastic,contact,dissipated,work,total";
std::string energy_row(double t, const EnergyState& energy);

/// sensitivity.csv: a row per output time, t and the derivatives of the columns of ends.csv with respect to each key.
std::string sensitivity_header(std::span<const Direction> directions);
std::string sensitivity_row(const Snapshot& at);

/// gauges.csv: a row per output time, t and gauge_columns().
std::string gauges_row(const Snapshot& at, std::span<const Gauge> gauges);

/// joints.csv: a row per output time, t and for each joint with a node on either side, those to the right being given,
/// u to its left and to its right and the force that pushes the two apart.
std::string joints_header(const Scene& scene);
std::string joints_row(const Snapshot& at, std::span<const std::size_t> nodes);

/// A word as a cell, RFC 4180: in quotes where it holds a comma, quotes or a new line.
std::string csv_text(const std::string& word);

std::string_view name(Where where);           ///< left, right, span or joint
std::string name(const ContactPlace& place);  ///< left, right, span or joint:<number>
/// left, right, span:<mesh node> or joint:<number>
std::string place(const Event& event);

}  // namespace viscobar
