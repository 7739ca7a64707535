#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "viscobar/case/case.hpp"
#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// The derivatives of a recording with respect to a parameter; NaN where there are none.
struct RecordedSensitivity {
  std::string key;                     ///< of the parameter
  std::vector<double> u;               ///< of Recording::u, likewise row by row
  std::vector<double> v;               ///< of Recording::v
  std::vector<double> reaction_left;   ///< K
  std::vector<double> reaction_right;  ///< K
};

/// A run kept in memory, to be compared with another: the field on a time grid, the reactions at the ends, the events.
/// On a mesh of one element it may hold the ends of a finer one, for a scheme that knows nothing else.
struct Recording {
  std::string label;                                    ///< in tables and reports
  Mesh mesh;                                            ///< J elements
  std::vector<double> times;                            ///< K output times
  std::vector<double> u;                                ///< displacement, K x (J+1), row by row
  std::vector<double> v;                                ///< velocity, likewise; empty where it is not known
  std::vector<double> reaction_left;                    ///< K, or empty where it is not known
  std::vector<double> reaction_right;                   ///< K, or empty where it is not known
  std::vector<Event> events;                            ///< contact changes in order of time
  Statistics statistics;                                ///< of the run
  std::vector<RecordedSensitivity> sensitivities = {};  ///< an entry for each direction of the case
  std::vector<EnergyState> energy = {};                 ///< K, or empty where it is not known

  /// Adds what a snapshot of a run with these directions tells.
  void keep(const Snapshot& snapshot, std::span<const Direction> directions);
  /// Observers of a run of the case that fill it, which both outlive. Its arrays do not move while they grow to so many
  /// output times.
  Observers filling(const Case& run, std::size_t rows);

  /// Displacement of the J+1 nodes at times[k].
  std::span<const double> displacement(std::size_t k) const {
    return std::span(u).subspan(k * mesh.nodes(), mesh.nodes());
  }
  /// Velocity of the J+1 nodes at times[k].
  std::span<const double> velocity(std::size_t k) const { return std::span(v).subspan(k * mesh.nodes(), mesh.nodes()); }
};

/// Runs a sound setup and keeps it, on its own output times. @throws IntegrationError
Recording record_setup(const Setup& setup);
/// The same for a sound case: a Solver.
inline Recording record(const Case& run) { return record_setup(resolve(run)); }

/// Any scheme, also one of your own: it advances the case and gives the recording on run.output_times(), which Recorder
/// makes out of its steps. Velocities, reactions, events and statistics may be missing.
using Solver = std::function<Recording(const Case& run)>;

}  // namespace viscobar
