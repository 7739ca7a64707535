#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/dynamics/unknowns.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

struct Piece;

/// A joint of a chain with a node on either side, a contact or a spring.
struct JointNodes {
  std::size_t number = 1;  ///< from the left, bonded ones counted
  std::size_t node = 1;    ///< mesh node to its right; the one before is to its left
  double stiffness = 0.0;  ///< of a spring
  double damping = 0.0;    ///< of a spring
  bool contact = false;    ///< true if it is one
};

/// The P1 elements of a bar, or of several in line: springs E / (int dx / A) and dashpots eta / (int dx / A) between
/// neighbouring nodes, the forces -(E K u + eta K w) of which are differences of stresses.
class Elements {
 public:
  /// @throws std::invalid_argument where the pieces do not fit the scene
  Elements(const Scene& scene, const Mesh& mesh, const Unknowns& unknowns,
           std::shared_ptr<const std::vector<Piece>> pieces);

  const Mesh& mesh() const { return mesh_; }                         ///< that they are of
  const Bar& bar() const { return bar_; }                            ///< E and eta
  const std::vector<Piece>& pieces() const { return *pieces_; }      ///< one, or those of a chain
  bool is_chain() const { return chain_; }                           ///< of several bars in line
  const std::vector<JointNodes>& joints() const { return joints_; }  ///< of a chain, that are not bonded
  /// True if no row of K, and none of the mass away from the ends, differs from the next one.
  bool rows_alike() const { return inverse_spacing_.empty(); }
  /// int dx / A over an element: its size, where the section does not vary. E / (int dx / A) is a spring. Of a chain E
  /// is that of bar(): int (E / E_e) dx / A, E / k at a joint that is a spring, infinite at a contact.
  double stretch(std::size_t element) const {
    if (chain_) return 1.0 / inverse_spacing_[element];
    return places_.empty() ? mesh_.element(element) : places_[element + 1] - places_[element];
  }
  /// 1 / stretch(), of a chain, where it may be 0.
  double stretch_weight(std::size_t element) const { return inverse_spacing_[element]; }
  /// The same of viscosity: eta / (eta / int dx / A). Of bars whose eta / E differ it is another one.
  double rate_stretch(std::size_t element) const {
    return inverse_rate_.empty() ? stretch(element) : 1.0 / inverse_rate_[element];
  }
  /// 1 / rate_stretch() of every element; empty if all are alike.
  const std::vector<double>& rate_weights() const { return inverse_rate_.empty() ? inverse_spacing_ : inverse_rate_; }
  /// h of the element of a bar that has the highest frequency, as one of bar() would have that.
  double finest() const { return chain_ ? finest_ : mesh_.smallest(); }
  double whole_stretch() const { return places_.empty() ? mesh_.length : places_.back(); }  ///< of the bar
  /// x / L of a node; of one bar whose section varies the share of int dx / A.
  double share(std::size_t node) const {
    return places_.empty() ? mesh_.node(node) / mesh_.length : places_[node] / places_.back();
  }
  /// True if it is no joint's, and within the mesh.
  bool is_of_bar(std::size_t element) const;
  /// The element to the right of an unknown's node; the one to its left at the last node of a bar. A rigid body alone
  /// has the spring beside it, or else the nearest element of a bar.
  std::size_t beside(std::size_t unknown) const;
  double stretch_beside(std::size_t unknown) const { return stretch(beside(unknown)); }  ///< of that

  /// out = -(E K u + eta K w). Stresses are differences of neighbours, so a rigid motion gives exactly zero.
  void force(std::span<const double> u, std::span<const double> w, std::span<double> out) const;
  /// (E K u + eta K v)_e of an end, of fields over all mesh nodes.
  double end_force(bool right, std::span<const double> u, std::span<const double> v) const;
  /// K_ii over the unknowns: the sum of 1/h of the elements beside, 2/h and, at an end that is not fixed, 1/h on a
  /// uniform mesh. Off the diagonal K is -1/h.
  double stiffness_diagonal(std::size_t i) const;
  /// out = m inertia + (c eta + k E) K (allocates only when `out` grows).
  void dynamic_stiffness(const BandedMatrix& inertia, double m, double c, double k, BandedMatrix& out) const;

  /// int u_x^2 of a displacement (fixed ends keep their displacement) and int w_x^2 of a velocity (they stand still);
  /// of a chain int (E_e / E) u_x^2 and int (eta_e / eta) w_x^2, joints included.
  double squared_strain(std::span<const double> u) const;
  double squared_strain_rate(std::span<const double> w) const;  ///< int w_x^2
  /// The same of velocities w(i), each an array of them at several times, summed up from `sum`.
  template <class Values>
  Values squared_strain_rate(auto&& w, Values sum) const {
    const double uniform = rows_alike() ? 1.0 / mesh_.spacing() : 0.0;
    std::size_t element = 0;
    const auto add = [&](const Values& difference) {
      sum += difference * difference * (inverse_spacing_.empty() ? uniform : rate_weights()[element]);
      ++element;
    };
    Values before = w(std::size_t{0});
    if (unknowns_.left_fixed()) add(before);
    for (std::size_t i = 1; i < unknowns_.size(); ++i) {
      const Values now = w(i);
      add(now - before);
      before = now;
    }
    if (unknowns_.right_fixed()) add(before);
    return sum;
  }

 private:
  void take_chain(const Scene& scene);
  void forces(std::span<const double> u, std::span<const double> w, std::span<double> out, auto&& stress) const;
  double squared_differences_of(std::span<const double> x, std::array<const double*, 2> walls,
                                std::span<const double> weights) const;
  double uniform_diagonal(std::size_t i) const;
  void assemble(const BandedMatrix& inertia, double m, auto&& spring, BandedMatrix& out) const;

  Mesh mesh_;
  Bar bar_;
  Unknowns unknowns_;
  bool chain_ = false;
  double finest_ = 0.0;  // of a chain
  std::shared_ptr<const std::vector<Piece>> pieces_;
  std::vector<JointNodes> joints_;
  std::vector<double> places_;              // int_0^x dx / A of every node; empty without it
  std::vector<double> inverse_spacing_;     // 1 / stretch() of every element; empty if all are alike
  std::vector<double> inverse_rate_;        // 1 / rate_stretch(), where that is another one
  std::vector<double> springs_, dashpots_;  // E and eta times these; empty likewise
};

}  // namespace viscobar
