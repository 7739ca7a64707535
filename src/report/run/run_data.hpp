#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "report/plot/thinning.hpp"
#include "report/run/thinned_events.hpp"
#include "report/run/thinned_field.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// What the report shows of a run, collected while it runs in memory that does not grow with it.
class ReportData {
 public:
  ReportData(const Case& run, const BarSystem& system);

  void add(const Snapshot& snapshot);
  void add(const Event& event);

  /// Some more than a picture of the whole can show, to zoom into.
  static constexpr std::size_t buckets = 800;
  struct End {
    plot::ThinnedLine displacement{buckets}, reaction{buckets}, traction{buckets};
    plot::ThinnedIntervals contacts;     // that are over
    std::optional<double> closed_since;  // of the one that is not

    /// Times in contact up to `now`, as far as a picture shows them.
    std::vector<plot::Interval> in_contact(double now) const;
    static void members(auto& end, auto&& each) {
      each(end.displacement, end.reaction, end.traction, end.contacts, end.closed_since);
    }
  };
  /// The columns of energy.csv.
  struct Energy {
    plot::ThinnedLine kinetic{buckets}, elastic{buckets}, contact{buckets}, dissipated{buckets}, work{buckets},
        total{buckets};
    static void members(auto& energy, auto&& each) {
      each(energy.kinetic, energy.elastic, energy.contact, energy.dissipated, energy.work, energy.total);
    }
  };
  /// Derivatives of the ends' displacements by a parameter.
  struct Slopes {
    plot::ThinnedLine left{buckets}, right{buckets};
    static void members(auto& slopes, auto&& each) { each(slopes.left, slopes.right); }
  };
  static constexpr std::size_t most_events = 50;

  std::size_t snapshots = 0;
  ThinnedField field, stress;
  End left, right;
  Energy energy;
  std::vector<Slopes> sensitivities;  // of each direction
  std::vector<Event> first_events;
  ThinnedEvents marked_events;
  static void members(auto& data, auto&& each) {
    each(data.snapshots, data.field, data.stress, data.left, data.right, data.energy, data.sensitivities,
         data.first_events, data.marked_events);
  }

  /// Contact springs exist: an obstacle and a penalised method.
  bool has_springs() const { return epsilon_.has_value(); }

 private:
  const BarSystem& system_;
  std::optional<double> epsilon_;
};

}  // namespace viscobar
