#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "viscobar/discretisation/mesh.hpp"

namespace viscobar {

/// The P1 functions phi_i of a bar of section A(x): linear not in x but in
///
///     s(x) = int_0^x dx / A,
///
/// so that A phi_i' is constant on an element, and int A E u_x phi_i' exact for every u. In s the bar is one of section
/// 1 and of density rho A^2. On element e xi(x) = (s(x) - s(x_e)) / s_e runs from 0 to 1, s_e = s(x_{e+1}) - s(x_e).
///
/// Integrals over elements are by Gauss' formula of sixteen points between the nodes and the breaks of A, others of
/// ten.
class VaryingSection {
 public:
  /// The first place in (after, until) at which A jumps or has a kink.
  using Breaks = std::function<std::optional<double>(double after, double until)>;

  /// @param area A(x); positive and finite, else results are not numbers
  /// @param breaks of A; empty: it is smooth
  VaryingSection(std::function<double(double)> area, const Breaks& breaks, const Mesh& mesh);

  double area(double x) const { return area_(x); }                               ///< A
  double stretch(std::size_t element) const { return elements_[element].size; }  ///< s_e
  const std::vector<double>& places() const { return places_; }                  ///< s(x_j)
  double along(std::size_t element, double x) const;                             ///< xi(x)
  double next_break(double after, double until) const;  ///< the first place at which A jumps or has a kink, or until
  /// int_e A xi^k dx, k = 0 to 3
  const std::array<double, 4>& moments(std::size_t element) const { return elements_[element].moments; }

 private:
  struct Element {
    double size = 0.0;
    std::array<double, 4> moments{};
  };

  template <class Add>
  void visit(double from, double to, Add&& add) const;
  double stretch(double from, double to) const;

  std::function<double(double)> area_;
  Mesh mesh_;
  std::vector<double> breaks_, places_;
  std::vector<Element> elements_;
};

}  // namespace viscobar
