#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "dynamics/penalised_system.hpp"
#include "integration/bernstein.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// The force of a span obstacle on the bar in the direction of u, the sum of its springs,
///
///     R(t) = sum over closed contacts i of  - s_i k_i (s_i u_i + gap_i) - c_i u_i'
///
/// (s, k, c as in PenalisedSystem), and the account of it: int R dt and max |R|, of the polynomial of each step.
class SpanForce {
 public:
  /// Both outlive it. Without a span obstacle it asks for nothing.
  SpanForce(const PenalisedSystem& system, SpanAccount& account);

  /// Appends the entries of (u, w) that it samples.
  void ask_for(std::vector<std::size_t>& entries);
  /// What is to be added to u to have displacements from here on; empty: nothing.
  void measure_from(std::span<const double> origin) { origin_ = origin; }
  /// Appends the positions of the entries of closed contacts among all.
  void select(std::vector<std::size_t>& positions) const;

  bool closed() const;
  /// Sample j of a step, by the entries of all.
  void look_at(std::size_t j, std::span<const double> y) { force_[j] = force(y); }
  /// R at the samples.
  const std::array<double, Bernstein::max_degree + 1>& samples() const { return force_; }
  /// max |R| so far
  double peak() const { return account_.peak_reaction; }
  /// Adds a step of that length.
  void add(double length, std::size_t order);

 private:
  struct Node {
    std::size_t contact, displacement, velocity;  // positions of its entries
    bool damped;                                  // whether there is one of the velocity
  };
  double force(std::span<const double> y) const;

  const PenalisedSystem& system_;
  SpanAccount& account_;
  std::vector<Node> nodes_;
  std::span<const double> origin_;
  std::array<double, Bernstein::max_degree + 1> force_{};
};

}  // namespace viscobar
