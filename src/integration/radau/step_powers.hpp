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

  /// The integrals over all of a step of that length, by Gauss' 8 points.
  template <class At>
  Flow over_step(double length, At&& at) {
    half_ = 0.5 * length;
    known_ = false;
    for (std::size_t k = 0; k < of_gauss; ++k) values_[k] = at(nodes()[k]);
    return over_all();
  }

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
  static constexpr std::size_t points = 17, of_gauss = 8;
  static const std::array<double, points>& nodes();  // Gauss' points, then the others
  Flow over_all() const;
  void expand();
  Flow integral(double s) const;

  double half_ = 0.0;
  bool known_ = false;                       // the coefficients
  std::array<Flow, points> values_{};        // at the nodes
  std::array<Flow, points> coefficients_{};  // by Legendre's polynomials
};

}  // namespace viscobar::radau
