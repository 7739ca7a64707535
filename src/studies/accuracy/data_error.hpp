#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "studies/accuracy/space_error.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar::accuracy {

/// Error of a mesh by its data, beside the term with its own power of h: from the formulas of u_0, u_1 and f, without a
/// run.
///
/// Waves that an element holds a quarter of, or more, are seen by no mesh of a ladder that is too coarse for all of
/// them. With the wave number k, the largest amplitudes V of a velocity, F of a load and U of a displacement, they move
/// the bar by
///
///     V min(1 / (c k), rho / (eta k^2)),     F / (E k^2),     U,
///
/// and by that share of it which their stretch is of an element, where it is shorter.
///
/// A load f(x,t) of no known structure enters a mesh by its values at nodes. Waves of it that are shorter than two
/// elements are other waves there, and nothing bounds their mean: they move a bar by F t^2 / (2 rho), and one with a
/// fixed end by F L^2 / E without resonance. They are looked for at three times and between its first breaks and
/// pulses.
///
/// A jump or a kink between nodes costs a part that is as large as its place in the element says: an order does not
/// show by it, and the error is no less than that of order 1, d / (r - 1), nor than what the difference before promises
/// with the power 2.
class DataError {
 public:
  /// `displacements`: true if errors are those of a displacement, to which waves add.
  explicit DataError(const Case& run, bool displacements = true);

  /// The error of a ladder with both. Of order 4, 2, ... it stays where there is neither.
  SpaceError of(SpaceError found, std::span<const MeshStep> ladder) const;

  /// The least number of elements whose nodes all breaks of u_0, u_1 and f are at: multiples of it keep the order that
  /// a mesh has without them. 1 where there are none, where they move, or where no number up to 128 does.
  std::size_t unit() const;
  /// The least number of elements that sees the waves of a load of no known structure.
  std::size_t least() const;
  /// True of a mesh that sees all waves. One that does not may be further from the next than from one that is coarser.
  bool sees(std::size_t elements) const;
  /// True of data with breaks or waves. The motion then has kinks or waves, over which no mesh can be interpolated
  /// to another's nodes.
  bool rough() const { return fronts_ || !breaks_.empty() || !waves_.empty(); }
  /// True of a load that enters by its values at nodes.
  bool nodal() const { return nodal_; }

 private:
  bool at_nodes(std::size_t elements) const;
  struct Wave {
    double detail, stretch, error;  // the shortest of its places' distances; of all; of the displacement
  };
  bool unseen(const Wave& wave, double elements) const;
  bool aliased(const Wave& wave, double elements) const;
  void add(const auto& f, const Places& places, auto&& moves);
  void add_waves(const auto& f, const auto& detail, auto&& moves, std::vector<Wave>& waves);
  void add_general(const GeneralLoad& load, const Case& run);

  double length_;
  std::optional<Case> chain_;  // of bars in line, whose nodes depend on how they share elements
  bool displacements_;
  bool fronts_ = false;  // that move
  bool nodal_ = false;
  std::vector<double> breaks_;  // places
  std::vector<Wave> waves_;
  std::vector<std::vector<Wave>> at_times_;  // those of a general load
};

/// The end of a viscous bar that stops dead with the speed v, at an obstacle, sends out a layer that no mesh resolves
/// at first. Soon after, 0.1 to 1.6 h^2 rho / eta, which may be between any two times at which errors are looked at,
/// the displacement beside it is wrong by
///
///     a v h min(h rho / eta, 1 / c),    a = max |u_i(s) - int_0^s erf(i / (2 sqrt r)) dr|.
///
/// In that a, x is counted in h and t in h^2 rho / eta, so that it is a number of the mass alone.
double layer_error(const Case& run, double speed);

}  // namespace viscobar::accuracy
