#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "discretisation/gauss.hpp"
#include "dynamics/penalised_system.hpp"
#include "integration/accounts/joint_forces.hpp"
#include "integration/accounts/span_force.hpp"
#include "integration/bernstein.hpp"
#include "integration/point_values.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// The rates of entries (see ContactWatch::look_at) by methods that hold no node with mass, where nobody asks for any.
inline constexpr auto no_rates = [](std::size_t, double) { return std::span<const double>(); };

/// Keeps the account of the ends and of a span obstacle's force (see RunAccount) over the steps of a stepwise run, on
/// the polynomials that each step is interpolated by: range of u and peak of R are theirs. The impulse of a closed
/// contact follows from its node's row,
///
///     int R dt = [rho M v + eta K u] + int (E K u - M f) dt,
///
/// whose integrand is as smooth as u. R itself may oscillate on a spring that the steps pass over. Where the springs
/// are softer than the element beside them, R is integrated itself: errors of u are multiplied by 1/epsilon, not by
/// E/h. A node with mass that is held has R = d/dt (rho M v) + eta K v + E K u - M f, its own velocity being 0. An
/// undamped massless node has no displacement that could be interpolated; its R is a multiple of its indicator (see
/// Indicators).
class ContactWatch {
 public:
  /// Both outlive it. Extremes that nobody reads stay as they are. With `apart` the impulses of springs() are left to
  /// integrate().
  ContactWatch(const PenalisedSystem& system, RunAccount& account, AccountExtremes extremes = {}, bool apart = false);

  /// Appends the entries of (u, w) that it samples and that are not there yet.
  void ask_for(std::vector<std::size_t>& entries);
  /// Appends the positions among all of those that it needs as long as the contacts are as they are.
  void select(std::vector<std::size_t>& positions) const;
  /// The same, of those that are not there yet, of the velocities whose rates it needs.
  void select_rates(std::vector<std::size_t>& positions) const;

  /// Content of a checkpoint, beside the account.
  static void members(auto& watch, auto&& each) {
    for (auto& end : watch.ends_) each(end.stored);
  }

  /// `origin` is added to u to have displacements from here on (see Origin); empty: nothing.
  void measure_from(std::span<const double> origin) {
    span_.measure_from(origin);
    joints_.measure_from(origin);
    if (origin.empty()) return;
    for (End& end : ends_) {
      end.origin = origin[end.unknown];
      if (end.next) end.origin_next = origin[*end.next];
      if (end.entries.size() > 5) end.origin_beyond = origin[end.entries[5]];
    }
  }

  /// Appends the forms of joints, as long as the contacts are as they are.
  void ask_for(std::vector<LinearForm>& forms) { joints_.ask_for(forms); }

  /// The run is at t in the state (u, w): at its beginning, and wherever contacts change.
  void begin(double t, std::span<const double> u, std::span<const double> w);

  /// See JointForces::take_first_forces().
  void take_first_forces(double t, std::span<const double> u, std::span<const double> w) {
    if (extremes_.peaks) joints_.take_first_forces(t, u, w);
  }

  /// True if the motion does not matter as long as the contacts are as they are.
  bool idle() const { return idle_; }
  /// True if the ends and what is closed there are springs or nothing, so that bounds of entries bound them.
  bool springs() const { return springs_; }
  /// True if such ends stay in the ranges that they have been in but for the end of a step, and their reactions below
  /// their peaks, by bounds of all entries over the step (see LegStepper::hull).
  bool within(std::span<const double> lowest, std::span<const double> highest, std::span<const double> last) const;
  /// Adds such a step up to `to`.
  void pass(double to, std::span<const double> last);
  /// Adds what joints have of the step, or the part of one, from `from` up to `to`, by all forms at its points.
  void add_joints(double from, double to, std::size_t order, std::span<const PointValues> forms) {
    joints_.add(from, to, order, forms, extremes_.peaks);
  }
  /// True if the step up to `to` counts but for joints, velocities being below `fastest` in it: not where an end is
  /// open and cannot have got beyond the range that it has been in.
  bool concerned(double to, double fastest) const;

  /// Looks at the step from `from` up to `to`, by the entries at its points and their rates.
  void look_at(double from, double to, std::size_t order, std::span<const PointValues> y,
               std::span<const PointValues> rates);
  /// The same with `sample(j, t)` and `rate(j, t)`, which give the entries at t = from + j (to - from) / order and
  /// their rates.
  template <class Sample, class Rate>
  void look_at(double from, double to, std::size_t order, Sample&& sample, Rate&& rate) {
    selected_.clear();
    select(selected_);
    sample_points(from, to, order, selected_, points_, sample);
    selected_.clear();
    select_rates(selected_);
    if (!selected_.empty()) sample_points(from, to, order, selected_, rate_points_, rate);
    look_at(from, to, order, std::span<const PointValues>(points_), std::span<const PointValues>(rate_points_));
  }

  /// Looks at the joints of the step likewise, for a method that has no forms.
  template <class Sample>
  void look_at_joints(double from, double to, std::size_t order, Sample&& sample) {
    forms_.clear();
    joints_.ask_for(forms_);
    selected_.clear();
    for (LinearForm& form : forms_)
      for (std::size_t k = 0; k < form.count; ++k) selected_.push_back(form.entries[k] = places_[form.entries[k]]);
    sample_points(from, to, order, selected_, points_, sample);
    form_points_.resize(forms_.size());
    for (std::size_t i = 0; i < forms_.size(); ++i)
      Points<16>::Map(form_points_[i].data()) = forms_[i].of_points<16>(points_);
  }

  /// Adds to the impulses of springs() that are closed what a step that has been added or passed brings: by Gauss'
  /// formula, which is as exact for a polynomial with half its samples.
  template <class Sample>
  void integrate(double from, double to, std::size_t order, Sample&& sample) {
    if (!apart_ || !springs_ || std::ranges::none_of(ends_, &End::shut)) return;
    const double half = 0.5 * (to - from);
    for (const auto& [node, weight] : gauss_for_degree(order)) {
      const double t = from + half * (1.0 + node);
      add_rates(half * weight, t, sample(t));
    }
    for (End& end : ends_)
      if (end.shut) end.account->impulse += end.stored_now - end.stored, end.stored = end.stored_now;
  }

  /// True if the samples are those of polynomials, to about 1e-10: the last difference is far below the values. With
  /// all extremes.
  bool resolved() const;

  /// The state is (u, w) in another frame now: no force has done it.
  void enter_frame(std::span<const double> u, std::span<const double> w);
  /// The velocities of a frame that moves have changed at once by that: no force has done it.
  void pass_kink(std::span<const double> change) {
    for (End& end : ends_)
      if (!end.direct && !end.contacts.empty()) end.stored += gained(end, change);
  }

  /// Adds the impulse of an impact of contact i, and what closed contacts elsewhere have of it: those of a rigid body,
  /// or of a node whose row of rho M reaches that of contact i. The velocities have changed by `change`.
  void strike(std::size_t i, double impulse, std::span<const double> change);

  /// Adds the step that it has looked at.
  void add();

 private:
  struct End {
    EndAccount* account;
    bool right;
    double wall;  // displacement of a fixed neighbour, or its own in a moving frame
    std::size_t unknown = 0;
    std::optional<std::size_t> next{};                // absent: the neighbour is fixed
    std::vector<std::size_t> contacts{};              // of its node, but for those that JointForces has
    bool follows = false;                             // its neighbour: massless and undamped
    bool direct = false;                              // true if R itself is integrated
    bool shut = false;                                // a contact of it is closed in the step looked at
    double modulus = 0.0, viscosity = 0.0;            // of the element beside it, over its length
    double stiffness = 0.0, dashpot = 0.0;            // of its support
    double mass = 0.0, coupling = 0.0, beyond = 0.0;  // of its row of rho M, which an end row takes one further
    bool sided = false;                               // true if its row has resistance along the bar
    // None of one that is fixed in a moving frame; u_n alone where it follows, u_e, or u_e, u_n, w_e, w_n, and the w
    // beyond, with a side that resists the u there, too.
    std::vector<std::size_t> entries{};
    double origin = 0.0, origin_next = 0.0, origin_beyond = 0.0, stored = 0.0, stored_now = 0.0;
    PointValues u{}, force{}, rate{};  // over the step looked at; the last two of a closed contact

    double stretch(std::span<const double> y) const {
      return next ? y[0] - y[1] + (origin - origin_next) : y[0] + (origin - wall);
    }
  };

  void watch(EndAccount& account, bool right);
  // Values of its entries.
  static std::array<double, 6> values_of(const End& end, std::span<const double> u, std::span<const double> w);
  void add_range(End& end);
  // Added to displacements in the frame it gives those of the bar, where that jumps on the side of the leg.
  double lift(const End& end, double t) const { return bar_.frame().moving() ? load_.lift(t, 0).of(end.right) : 0.0; }
  bool closed(const End& end) const;
  // Its first entries: of an open end the displacement alone.
  std::size_t needed(const End& end) const {
    return closed(end) ? end.entries.size() : std::min<std::size_t>(1, end.entries.size());
  }
  bool holds_mass(const End& end) const;
  static double momentum(const End& end, std::span<const double> y) {
    return end.mass * y[2] + end.coupling * y[3] + end.beyond * y[4];
  }
  // Momentum of its row by a change of the velocities.
  static double gained(const End& end, std::span<const double> change) {
    std::array<double, 6> values{};
    for (std::size_t k = 2; k < std::min<std::size_t>(5, end.entries.size()); ++k)
      values[k] = change[end.entries[k] - change.size()];
    return momentum(end, values);
  }
  double stored(const End& end, std::span<const double> y) const;
  double pull(const End& end, double t, double u, double w, std::size_t i) const;
  double side_row(const End& end, std::span<const double> y) const;
  double displacement(const End& end, double t, std::span<const double> y) const;
  double rate(const End& end, double t, std::span<const double> y) const;
  void add_rates(double weight, double t, std::span<const double> y);
  // Calls use(end, values) with its own entries of all.
  void each_shut(std::span<const double> y, auto&& use) {
    const std::size_t* first = positions_.data();
    for (End& end : ends_) {
      std::array<double, 6> values{};
      for (std::size_t e = 0; end.shut && e < end.entries.size(); ++e) values[e] = y[first[e]];
      if (end.shut) use(end, values);
      first += end.entries.size();
    }
  }
  double largest_reaction(const End& end, const std::size_t* position, std::span<const double> lowest,
                          std::span<const double> highest) const;
  double reaction(const End& end, double t, std::span<const double> y) const;
  void look_at(End& end, const std::size_t* first, double from, std::span<const PointValues> y) const;
  bool add_alike_rates(End& end, const std::size_t* first, std::span<const PointValues> y) const;
  bool take_holding_force(End& end, const std::size_t* first, double from, std::span<const PointValues> y) const;
  void add_inertia(End& end, const std::size_t* first, std::span<const PointValues> rates) const;
  std::pair<double, double> beyond(const PointValues& values) const;
  std::span<const double> used(const PointValues& values) const { return std::span(values).first(order_ + 1); }
  Bernstein through(const PointValues& values) const { return Bernstein::through(used(values)); }

  const Contacts& contacts_;
  const ActingLoad& load_;
  const BarSystem& bar_;
  AccountExtremes extremes_;
  bool apart_, springs_ = false, idle_ = false;
  std::vector<End> ends_;
  SpanForce span_;
  JointForces joints_;
  std::vector<std::size_t> positions_;          // of the ends' entries among all, end by end
  std::vector<std::size_t> selected_, places_;  // the latter: of each entry that forms take
  std::vector<LinearForm> forms_;
  std::vector<PointValues> form_points_;
  std::vector<PointValues> points_, rate_points_;  // of these
  double length_ = 0.0, end_ = 0.0;                // of the step looked at, which a contact change may cut
  double seen_ = 0.0;                              // up to where ends are accounted for
  std::size_t order_ = 0;
};

}  // namespace viscobar
