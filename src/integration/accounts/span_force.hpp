#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dynamics/contacts.hpp"
#include "integration/point_values.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// The force of a span obstacle on the bar in the direction of u, the sum of its springs,
///
///     R(t) = sum over closed contacts i of  - s_i k_i (s_i u_i + gap_i) - c_i u_i'
///
/// (s, k, c as in ContactLaw), and the account of it: int R dt and max |R|, of the polynomial of each step.
class SpanForce {
 public:
  /// Both outlive it. Without a span obstacle it asks for nothing.
  SpanForce(const Contacts& contacts, SpanAccount& account);

  /// Appends the entries of (u, w) that it samples.
  void ask_for(std::vector<std::size_t>& entries);
  /// `origin` is added to u to have displacements from here on; empty: nothing.
  void measure_from(std::span<const double> origin) { origin_ = origin; }
  /// Appends the positions of the entries of closed contacts among all.
  void select(std::vector<std::size_t>& positions) const;

  bool closed() const;
  /// At the points of a step, by the entries of all.
  void look_at(std::size_t order, std::span<const PointValues> y);
  /// R there.
  const PointValues& samples() const { return force_; }
  /// max |R| of the run so far
  double peak() const { return account_.peak_reaction; }
  /// Adds a step of that length, which ends at `to`.
  void add(double to, double length, std::size_t order);

 private:
  struct Node {
    std::size_t contact, displacement, velocity;  // positions of its entries
    bool damped;                                  // true if the entries include the velocity
  };

  const Contacts& contacts_;
  SpanAccount& account_;
  std::vector<Node> nodes_;
  std::span<const double> origin_;
  PointValues force_{};
};

}  // namespace viscobar
