#pragma once

#include <optional>

#include "dynamics/gauge.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

/// Reads a column of ends.csv or gauges.csv from fields: `u` and `v` over all nodes, and the reactions of both ends.
class ColumnReader {
 public:
  ColumnReader(TraceColumn column, double place, const Mesh& mesh, const Bar& bar) : column_(column) {
    if (column >= TraceColumn::u_at) gauge_.emplace(mesh, bar, place);
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
    }
    return 0.0;
  }

 private:
  TraceColumn column_;
  std::optional<Gauge> gauge_;
};

}  // namespace viscobar
