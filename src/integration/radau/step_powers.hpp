#pragma once

#include <array>
#include <cstddef>

namespace viscobar::radau {

/// The powers of the energy account within a step. A power is a product of two polynomials of degree 8 in time, but
/// for a load: its interpolant in 17 points of the step, those of Gauss' formula with 8 and of Kronrod's extension of
/// it, has degree 16. So every output within the step asks for sums only.
///
/// Times of a step are in [-1, 1]; at(s) returns the powers at one.
class StepPowers {
 public:
  using Flow = std::array<double, 3>;
  static constexpr std::size_t of_gauss = 8;

  /// The integrals over all of a step of that length, by the powers at Gauss' points, the first of nodes().
  Flow over_step(double length, const std::array<Flow, of_gauss>& at_gauss);

  static constexpr std::size_t points = 17;
  static const std::array<double, points>& nodes();  ///< Gauss' points, then the others

  /// The integrals up to a time of that step.
  template <class At>
  Flow up_to(double s, At&& at) {
    if (!known_) {
      for (std::size_t k = of_gauss; k < points; ++k) values_[k] = at(nodes()[k]);
      expand();
    }
    return integral(s);
  }

 private:
  void expand();
  Flow integral(double s) const;

  double half_ = 0.0;
  bool known_ = false;                       // the coefficients
  std::array<Flow, points> values_{};        // at the nodes
  std::array<Flow, points> coefficients_{};  // by Legendre's polynomials
};

}  // namespace viscobar::radau
