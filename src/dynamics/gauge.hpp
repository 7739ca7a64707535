#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "discretisation/interpolant.hpp"
#include "dynamics/pieces.hpp"
#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// True if a place lies behind another one by more than the rounding of lengths that were added up.
inline bool is_behind(double x, double end) { return x > end * (1.0 + 1e-12); }

/// By the nodes of a member of a chain, or of a bar alone, at x from its left end. Where A jumps or has a kink, u_x or
/// u_xx jumps: the nodes are of one side, at the place itself of the left one, and an element that is cut by such a
/// place has its P1 functions.
Interpolant interpolant_of(const Piece& piece, double x);

/// A place of the bar where its motion is read: u, v, strain u_x and stress E u_x + eta v_x.
class Gauge {
 public:
  /// By the nodes of its own bar, at a joint of the left one; on one side of a break of the section.
  Gauge(const Mesh& mesh, const Scene& scene, double x);
  Gauge(const Mesh& mesh, const Bar& bar, double x);

  struct Reading {
    double u, v, strain, stress;
  };
  /// @param u, v of all nodes
  Reading operator()(std::span<const double> u, std::span<const double> v) const;

  double x() const { return x_; }
  /// On a bar of the same mesh and another material.
  void take(const Bar& bar) { modulus_ = bar.modulus, viscosity_ = bar.viscosity; }

 private:
  Interpolant at_;
  double x_, modulus_, viscosity_;
};

/// Mean stress of element j, whatever its section, (E (u_{j+1} - u_j) + eta (v_{j+1} - v_j)) / h_j, of J+1 nodal
/// values; 0 at a joint of a chain, an element of no length. It is not inline: which product is fused with the sum
/// would be another choice in each caller, and so the last bit.
double element_stress(const Bar& bar, const Mesh& mesh, std::span<const double> u, std::span<const double> v,
                      std::size_t j);

/// One for each of output.gauges.
std::vector<Gauge> make_gauges(std::span<const double> places, const Mesh& mesh, const Scene& scene);

/// The columns of gauges.csv behind t: u@X, v@X, strain@X, stress@X for each place X.
std::vector<std::string> gauge_columns(std::span<const double> places);

}  // namespace viscobar
