#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/gauge.hpp"
#include "viscobar/studies/ensemble/ensemble.hpp"

namespace viscobar::bars {

/// The outputs of all bars, laid out: the values of a bar are those of all outputs one after the other.
struct Layout {
  /// A time at which a bar is looked at: for the k-th number of a trace or gauge, or as probe k of the error.
  struct Look {
    static constexpr std::size_t probe = ~std::size_t{0};
    double time;
    std::size_t output, k;  // output: or probe
  };

  /// @param judged runs of a bar are compared
  Layout(std::vector<EnsembleOutput> told, const Case& run, bool judged);

  std::vector<EnsembleOutput> outputs;
  std::vector<std::optional<Gauge>> gauges;  // of outputs, on the bar of the case
  std::vector<std::size_t> first;            // where the values of each output begin
  std::size_t width = 0;                     // of all
  std::vector<Look> looks;                   // in the order of time
  std::vector<double> times;                 // of them, each once
  bool fields = false;                       // all nodes are looked at, not the ends alone
  bool reactions = false, peaks = false, impulses = false;
  std::vector<std::size_t> inside;  // where the values have a displacement of a gauge, or of a node at the end
  std::size_t most_changes = 0;
  // Between probes, in which so many intervals of the finest output lie.
  double period;
  std::size_t intervals = 1;
  Mesh mesh;  // of the case
};

/// The values of one bar and what tells their error from those of another run of it.
struct BarValues {
  static constexpr std::size_t probes = 64;

  BarValues() = default;  // without values
  explicit BarValues(const Layout& layout);
  void changes_at(const Layout& layout, std::span<const double> times);
  /// By the numbers of EnsembleOutput::account.
  void accounts(const Layout& layout, std::span<const double> impulse, std::span<const double> peak);

  std::vector<double> values;                         // layout.width
  std::array<std::array<double, probes>, 2> ends{};   // u at times j period, j from 1 on
  std::array<std::array<double, probes>, 2> means{};  // of u up to each of these times from the one before, in lanes
  std::vector<double> changes;
  std::array<double, 2> impulse{};
  double largest = 0.0;                  // |u| of probes and start
  bool brief = false;                    // see LaneAccounts
  std::vector<double> joints, impulses;  // of a chain: u of both sides of its joints at the same times; of joints
  std::vector<double> inside;            // u of gauges and final states, see Layout::inside
};

/// Writes the four numbers of a gauge, or without one u and v of all nodes.
void write_fields(const Gauge* gauge, std::span<const double> u, std::span<const double> v, double* to);

/// No estimate is smaller.
inline constexpr double rounding = 1e-12;

/// The largest difference of two runs of a bar, as EnsembleStudy::error.
double difference(const Layout& layout, const BarValues& a, const BarValues& b, double end);

}  // namespace viscobar::bars
