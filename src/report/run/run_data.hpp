#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/gauge.hpp"
#include "report/plot/axis.hpp"
#include "report/plot/thinning.hpp"
#include "run/contact_places.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// A field over space and time as far as a picture shows it: every 2^k-th output time, k growing so that there
/// are never more than 400 of them, and every stride-th place, at most 401 of a bar, the ends of each member of a chain
/// always among them. The last output time is kept, too.
class ThinnedField {
 public:
  /// Places of values: the nodes of a mesh, or the middles of its elements.
  enum class At { nodes, elements };
  /// @param members the first and the last node of each member of a chain
  explicit ThinnedField(const Mesh& mesh, At at = At::nodes,
                        const std::vector<std::pair<std::size_t, std::size_t>>& members = {});

  void add(double time, std::span<const double> values) {
    add_each(time, [&](std::size_t j) { return values[j]; });
  }
  /// value(j) at place j
  template <class Value>
  void add_each(double time, Value&& value) {
    last_.time = time;
    for (std::size_t k = 0; k < nodes_.size(); ++k) last_.values[k] = value(nodes_[k]);
    kept_.add(last_);
  }

  /// Output times kept, the last one included.
  std::size_t rows() const { return kept_.buckets().size() + (kept_.in_last() > 1 ? 1 : 0); }
  double time(std::size_t row) const { return at(row).time; }
  std::vector<double> times() const;
  std::span<const double> row(std::size_t row) const { return at(row).values; }
  const std::vector<double>& x() const { return x_; }
  /// The places kept of a member of a chain, or of the bar: of a rigid one its node, and no element.
  struct Part {
    std::size_t first, count;
    std::size_t last() const { return first + count - 1; }
  };
  const std::vector<Part>& parts() const { return parts_; }
  plot::Range range() const;
  std::pair<std::vector<double>, std::vector<double>> envelope() const;

  std::size_t time_stride() const { return kept_.stride(); }
  std::size_t node_stride() const { return node_stride_; }

  static void members(auto& field, auto&& each) { each(field.kept_, field.last_); }

 private:
  static constexpr std::size_t most = 400;
  struct Row {
    double time = 0.0;
    std::vector<double> values;
    void join(const Row&) {}  // the first of some stands for all
    static void members(auto& row, auto&& each) { each(row.time, row.values); }
  };
  const Row& at(std::size_t row) const { return row < kept_.buckets().size() ? kept_.buckets()[row] : last_; }

  std::size_t node_stride_;
  std::vector<std::size_t> nodes_;
  std::vector<Part> parts_;
  std::vector<double> x_;
  plot::Thinned<Row> kept_{most};
  Row last_;
};

/// Data of the report of a run, collected while it runs in memory that does not grow with it.
class ReportData {
 public:
  ReportData(const Case& run, const BarSystem& system);

  void add(const Snapshot& snapshot);
  void add(const Event& event);

  /// Some more than a picture of the whole can show, to zoom into.
  static constexpr std::size_t buckets = 800;
  struct End {
    plot::ThinnedLine displacement{buckets}, reaction{buckets}, traction{buckets};
    plot::ThinnedIntervals contacts;     // that are over, with the peaks of their reactions
    std::optional<double> closed_since;  // of the one that is not

    void add(const Event& event);
    /// Times in contact up to `now`, as far as a picture shows them; the one that lasts has that peak.
    std::vector<plot::Interval> in_contact(double now, const ContactPeak& lasting) const;
    static void members(auto& end, auto&& each) {
      each(end.displacement, end.reaction, end.traction, end.contacts, end.closed_since);
    }
  };
  /// Columns of energy.csv as they are drawn.
  enum class Drawn { always, with_springs, where_not_zero };
  struct EnergyColumn {
    const char* name;
    Drawn drawn;
    double (*value)(const EnergyState& energy);
  };
  static constexpr std::array energy_columns = {
      EnergyColumn{"kinetic", Drawn::always, [](const EnergyState& energy) { return energy.kinetic; }},
      EnergyColumn{"elastic", Drawn::always, [](const EnergyState& energy) { return energy.elastic; }},
      EnergyColumn{"contact springs", Drawn::with_springs, [](const EnergyState& energy) { return energy.contact; }},
      EnergyColumn{"dissipated", Drawn::where_not_zero, [](const EnergyState& energy) { return energy.dissipated; }},
      EnergyColumn{"work", Drawn::where_not_zero, [](const EnergyState& energy) { return energy.work; }},
      EnergyColumn{"total", Drawn::always, [](const EnergyState& energy) { return energy.total(); }}};
  /// Derivatives of the ends' displacements by a parameter.
  struct Slopes {
    plot::ThinnedLine left{buckets}, right{buckets};
    static void members(auto& slopes, auto&& each) { each(slopes.left, slopes.right); }
  };
  struct Readings {
    plot::ThinnedLine displacement{buckets}, stress{buckets};
    static void members(auto& readings, auto&& each) { each(readings.displacement, readings.stress); }
  };
  /// The one with the larger velocity of some events in a row.
  struct Fastest {
    Event event;
    void join(const Fastest& next);
    static void members(auto& fastest, auto&& each) { each(fastest.event); }
  };
  static constexpr std::size_t most_events = 50, most_marks = 2000;

  std::size_t snapshots = 0;
  ThinnedField field, stress;
  End left, right;
  End span;                 // all of its nodes together: reaction and contacts alone
  std::vector<End> joints;  // of Elements::joints(), likewise
  std::vector<plot::ThinnedLine> energy{energy_columns.size(), plot::ThinnedLine(buckets)};  // of energy_columns
  std::vector<Slopes> sensitivities;                                                         // of each direction
  std::vector<Readings> readings;                                                            // of each gauge
  std::vector<Event> first_events;
  plot::Thinned<Fastest> marked_events{most_marks};
  static void members(auto& data, auto&& each) {
    each(data.snapshots, data.field, data.stress, data.left, data.right, data.span, data.joints, data.energy,
         data.sensitivities, data.readings, data.first_events, data.marked_events);
  }

  bool has_springs() const { return has_springs_; }
  /// The end, span or joint at a place of contacts.
  const End& at(const ContactPlace& place) const;

 private:
  const BarSystem& system_;
  const std::vector<Gauge> gauges_;
  const std::vector<Bar> bars_;  // of each element of a chain
  bool has_springs_;
};

}  // namespace viscobar
