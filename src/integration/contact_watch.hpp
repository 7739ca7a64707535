#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/penalised_system.hpp"
#include "integration/bernstein.hpp"
#include "integration/span_force.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// Keeps the account of the ends and of a span obstacle's force (see RunAccount) over the steps of a stepwise run, on
/// the polynomials that each step is interpolated by: range of u and peak of R are theirs. The impulse of a closed
/// contact follows from its node's row,
///
///     int R dt = [rho M v + eta K u] + int (E K u - M f) dt,
///
/// whose integrand is as smooth as u. R itself may oscillate on a spring that the steps pass over. A node with mass
/// that is held has R = d/dt (rho M v) + eta K v + E K u - M f, its own velocity being 0. An undamped massless node has
/// no displacement that could be interpolated; its R is a multiple of its indicator (see PenalisedSystem).
class ContactWatch {
 public:
  /// Both outlive it.
  ContactWatch(PenalisedSystem& system, RunAccount& account);

  /// Appends the entries of (u, w) that it samples.
  void ask_for(std::vector<std::size_t>& entries) {
    for (End& end : ends_)
      for (const std::size_t entry : end.entries) {
        selected_.push_back(entries.size());
        entries.push_back(entry);
      }
    of_ends_ = selected_.size();
    span_.ask_for(entries);
  }
  /// Positions of its entries among all, those of open contacts of a span obstacle left out.
  const std::vector<std::size_t>& selected() {
    selected_.resize(of_ends_);
    span_.select(selected_);
    return selected_;
  }

  /// What a checkpoint holds of it, beside the account.
  static void members(auto& watch, auto&& each) {
    for (auto& end : watch.ends_) each(end.stored);
  }

  /// What is to be added to u to have displacements from here on (see PenalisedSystem); empty: nothing.
  void measure_from(std::span<const double> origin) {
    span_.measure_from(origin);
    if (origin.empty()) return;
    for (End& end : ends_) {
      end.origin = origin[end.unknown];
      if (end.next) end.origin_next = origin[*end.next];
    }
  }

  /// The run is at t in the state (u, w).
  void begin(double t, std::span<const double> y);

  /// Whether the step up to `to` counts, velocities being below `fastest` in it: not where an end is open and cannot
  /// have got beyond the range that it has been in.
  bool concerned(double to, double fastest) const;

  /// Looks at the step from `from` up to `to`, `sample(j, t)` giving the entries at t = from + j (to - from) / order.
  template <class Sample>
  void look_at(double from, double to, std::size_t order, Sample&& sample) {
    begin_look(from, to, order);
    for (std::size_t j = 0; j <= order; ++j) {
      const double t = j == order ? to : from + length_ * static_cast<double>(j) / static_cast<double>(order);
      look_at(j, t, sample(j, t));
    }
  }
  /// The same in parts, by who has such samples of all entries anyway: after begin_look(), for each j in order.
  void begin_look(double from, double to, std::size_t order) {
    length_ = to - from;
    seen_ = to;
    order_ = order;
  }
  void look_at(std::size_t j, double t, std::span<const double> y);

  /// Whether the samples are those of polynomials, to about 1e-10: the last difference is far below the values.
  bool resolved() const;

  /// The velocities of a frame that moves have changed at once by that: no force has done it.
  void pass_kink(std::span<const double> change) {
    for (End& end : ends_) {
      if (end.follows || end.contacts.empty()) continue;
      std::array<double, 5> values{};
      for (std::size_t k = 2; k < end.entries.size(); ++k) values[k] = change[end.entries[k] - change.size()];
      end.stored += momentum(end, values);
    }
  }

  /// Adds the impulse of an impact of contact i.
  void strike(std::size_t i, double impulse);

  /// Adds the step that it has looked at.
  void add();

 private:
  using Samples = std::array<double, Bernstein::max_degree + 1>;

  struct End {
    EndAccount* account;
    std::size_t unknown;
    std::optional<std::size_t> next;    // absent: the neighbour is fixed
    double wall;                        // displacement of a fixed neighbour
    std::vector<std::size_t> contacts;  // of its node
    bool follows;                       // its neighbour: massless and undamped
    double modulus, viscosity;          // of the element beside it, over its length
    double mass, coupling, beyond;      // of its row of rho M, which an end row takes one further
    std::vector<std::size_t> entries;   // none of one that is fixed in a moving frame; u_n alone where it follows, u_e,
                                        // or u_e, u_n, w_e, w_n, and the w beyond
    double origin = 0.0, origin_next = 0.0, stored = 0.0, stored_now = 0.0;
    Samples u{}, force{}, rate{};  // over the step looked at; the last two of a closed contact
    Samples momentum{};            // of its row, where inertia has a share in the force
    bool right = false;
    double stiffness = 0.0, dashpot = 0.0;  // of its mount

    double stretch(std::span<const double> y) const {
      return next ? y[0] - y[1] + (origin - origin_next) : y[0] + (origin - wall);
    }
  };

  void watch(EndAccount& account, std::size_t unknown, std::optional<std::size_t> next, std::optional<double> wall);
  void follow(EndAccount& account, double displacement, bool right);
  // What is to be added to displacements of the frame.
  double lift(const End& end, double t) const {
    if (!bar_.moving()) return 0.0;
    const Lift lift = bar_.lift(t, 0);
    return end.right ? lift.right : lift.left;
  }
  bool closed(const End& end) const;
  bool holds_mass(const End& end) const;
  double momentum(const End& end, std::span<const double> y) const {
    return end.mass * y[2] + end.coupling * y[3] + end.beyond * y[4];
  }
  double stored(const End& end, std::span<const double> y) const;
  double pull(const End& end, double t, double u, double w, std::size_t i) const;
  double displacement(const End& end, double t, std::span<const double> y) const;
  double reaction(const End& end, double t, std::span<const double> y) const;
  void look_at(End& end, std::size_t j, double t, std::span<const double> y);
  std::pair<double, double> beyond(const Samples& values) const;
  Bernstein through(const Samples& values) const { return Bernstein::through(std::span(values).first(order_ + 1)); }

  PenalisedSystem& system_;
  const BarSystem& bar_;
  std::vector<End> ends_;
  SpanForce span_;
  std::vector<std::size_t> selected_;
  std::size_t of_ends_ = 0;           // of them
  double length_ = 0.0, seen_ = 0.0;  // of the step looked at, and its end
  std::size_t order_ = 0;
};

}  // namespace viscobar
