#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "viscobar/case/recording.hpp"

namespace viscobar {

/// ||u||_{L2} and ||u_x||_{L2} of a P1 function given by its nodal values: exact, by (h/6) [2 1; 1 2] per element.
double l2_norm(const Mesh& mesh, std::span<const double> nodal);
double h1_seminorm(const Mesh& mesh, std::span<const double> nodal);  ///< ||u_x||_{L2}

/// A time in contact at one place: from a closing to the next opening, shorter interruptions than `merge` left out, so
/// that a chattering contact counts once. `bounces` is the number of closings in it.
struct ContactPeriod {
  Where where = Where::left;  ///< of the obstacle
  std::size_t node = 0;       ///< mesh node
  double begin = 0.0;         ///< time of the first closing
  double end = 0.0;           ///< time of the last opening
  /// Integral of the end's reaction: of the run's account, without one by the trapezoidal rule over the times inside;
  /// absent where there is none.
  std::optional<double> impulse = std::nullopt;
  std::size_t bounces = 1;  ///< closings
};

/// Contacts in the order of their beginning; one still closed at the end of the recording ends there.
std::vector<ContactPeriod> contact_periods(const Recording& recording, double merge);

/// How far two recordings of one scene are apart. Where one of them has the ends only (a mesh of one element), or no
/// velocity, the norms that need the field are absent.
struct Difference {
  std::optional<double> displacement_l2;  ///< max over time of the L2 norm
  std::optional<double> displacement_h1;  ///< max over time of the H1 seminorm
  std::optional<double> velocity_l2;      ///< max over time of the L2 norm
  double end_trace = 0.0;                 ///< max over time and both ends of |u - u'|
  std::size_t events = 0;                 ///< contact changes of the one recording
  std::size_t events_other = 0;           ///< and of the other
  /// Closings with closings and openings with openings, place by place and in order of time, so that the shifts are
  /// small: a change that one of the two lacks stays unmatched.
  std::size_t events_matched = 0;
  std::optional<double> largest_event_shift;  ///< over the matched events
  std::optional<double> energy_final;         ///< difference of the final energies
  /// A contact that both recordings have.
  struct Contact {
    ContactPeriod first;  ///< in the one recording
    ContactPeriod other;  ///< in the other
  };
  std::vector<Contact> contacts;  ///< contact periods, matched likewise
};

/// @throws std::invalid_argument when meshes (other than that of the ends) or time grids differ
Difference compare(const Recording& first, const Recording& other);

}  // namespace viscobar
