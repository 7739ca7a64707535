#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "dynamics/gauge.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

/// Why a column is none of a scene, behind its name; absent: it is one.
inline std::optional<std::string> place_refusal(const std::optional<std::pair<TraceColumn, double>>& column,
                                                const Scene& scene) {
  if (column && is_of_joint(column->first)) {
    const std::size_t last = std::max<std::size_t>(1, scene.chain.size()) - 1;
    for (std::size_t k = 0; k < last; ++k)
      if (column->second == static_cast<double>(k + 1) && scene.chain[k].joint.kind != JointKind::bonded)
        return std::nullopt;
    return fmt::format("is no joint of the scene that is not bonded; it has {} joints", last);
  }
  if (column && column->second >= 0.0 && !is_behind(column->second, scene.bar.length)) return std::nullopt;
  return fmt::format("is no place of the bar, 0 <= x <= {}, as in u@0.25", scene.bar.length);
}

/// Reads a column of ends.csv, gauges.csv or joints.csv from fields: `u` and `v` over all nodes, the reactions of both
/// ends, and the forces of joints.
class ColumnReader {
 public:
  /// A column of ends.csv.
  explicit ColumnReader(TraceColumn column) : column_(column) {}
  /// `scene` has the material at a gauge.
  ColumnReader(TraceColumn column, double place, const BarSystem& system, const Scene& scene) : column_(column) {
    if (is_of_gauge(column)) gauge_.emplace(system.mesh(), scene, place);
    if (!is_of_joint(column)) return;
    while (static_cast<double>(system.elements().joints()[joint_].number) != place) ++joint_;
    node_ = system.elements().joints()[joint_].node;
  }

  template <class Fields>
  double operator()(const Fields& at) const {
    switch (column_) {
      case TraceColumn::u_left: return at.u.front();
      case TraceColumn::v_left: return at.v.front();
      case TraceColumn::reaction_left: return at.reaction_left;
      case TraceColumn::u_right: return at.u.back();
      case TraceColumn::v_right: return at.v.back();
      case TraceColumn::reaction_right: return at.reaction_right;
      case TraceColumn::u_at: return (*gauge_)(at.u, at.v).u;
      case TraceColumn::v_at: return (*gauge_)(at.u, at.v).v;
      case TraceColumn::strain_at: return (*gauge_)(at.u, at.v).strain;
      case TraceColumn::stress_at: return (*gauge_)(at.u, at.v).stress;
      case TraceColumn::u_left_of: return at.u[node_ - 1];
      case TraceColumn::u_right_of: return at.u[node_];
      case TraceColumn::force_of:
        if constexpr (requires { at.joint_forces; }) return at.joint_forces[joint_];
    }
    return 0.0;
  }

 private:
  TraceColumn column_;
  std::size_t joint_ = 0, node_ = 0;
  std::optional<Gauge> gauge_;
};

}  // namespace viscobar
