#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "discretisation/lane_factor.hpp"
#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar::bars {

[[gnu::always_inline]] inline Lanes larger(const Lanes& a, const Lanes& b) { return std::experimental::max(a, b); }

/// Some neighbouring lanes, as many as V has, from one on.
template <class V>
V load_part(const Lanes& lanes, std::size_t from) {
  return V(reinterpret_cast<const double*>(&lanes) + from, std::experimental::element_aligned);
}
template <class V>
void store_part(const V& part, Lanes& lanes, std::size_t from) {
  part.copy_to(reinterpret_cast<double*>(&lanes) + from, std::experimental::element_aligned);
}

/// The part of a bar's equations that all bars in lanes share: M of density and length 1, and L / h of each element.
struct Pattern {
  BandedMatrix inertia;            ///< n unknowns
  std::vector<double> stretch;     ///< n + 1: L / h of the element before each unknown, and after the last; 0: none
  std::array<bool, 2> contact{};   ///< an obstacle at the left and the right end
  std::array<double, 2> sign{};    ///< s of it
  std::array<bool, 2> massless{};  ///< contact nodes without mass
  std::array<bool, 2> mounted{};   ///< ends with a spring, a dashpot or a mass in any bar

  std::size_t size() const { return inertia.size(); }  ///< n
  bool fixed(bool right) const { return stretch[right ? size() : 0] != 0.0; }
  /// True if no element differs from another.
  bool is_of_alike() const {
    return std::ranges::all_of(stretch, [&](double one) { return one == 0.0 || one == stretch[1]; });
  }
};

/// A part of the load: weights(i) times a function of time, or 1.
struct LoadPart {
  std::vector<double> weights;  ///< n
  TimeFunction history;         ///< empty: 1
};

/// The numbers of one bar.
struct Member {
  Bar bar;
  std::array<double, 2> gap{}, stiffness{}, dashpot{}, mass{};  ///< of the left and the right end
  std::array<double, 2> wall{};                                 ///< displacement of a fixed end
  double restitution = 0.0;                                     ///< by Paoli and Schatzman
  const State* data = nullptr;                                  ///< u_0, v_0 of the n unknowns
  const State* start = nullptr;                                 ///< the same, its high modes settled
  const std::vector<LoadPart>* load = nullptr;                  ///< null: none
};

/// A state of the bars in lanes at one time: unknowns in their order, or the first and the last alone.
struct LaneSample {
  std::span<const Lanes> u, v;
  std::array<Lanes, 2> reaction;  ///< of the obstacles at the ends, in the direction of u
  std::array<Lanes, 2> way{};     ///< int u dt / step of both ends, by trapezia
};

/// Accounts of a run of bars in lanes.
struct LaneAccounts {
  std::array<Lanes, 2> impulse{}, peak{};
  Lanes brief = 0.0;                                    ///< 1 where an end with a mass was held for two steps or less
  std::array<std::vector<double>, lane_count> changes;  ///< times of contact changes
  std::array<bool, lane_count> finite{};
};

/// When a run in lanes is to be seen.
struct LaneOutputs {
  std::span<const double> times;  ///< in order, in [begin, end]
  bool fields = false;            ///< all unknowns, not the ends alone
  std::size_t most_changes = 0;
  std::function<void(std::size_t k, const LaneSample&)> sample;  ///< at times[k]
};

/// Scheme (2.8) for 16 bars side by side, a bar a lane: the same arithmetic as TimeStep and its run on the order of the
/// nodes, but for rounding.
class LaneScheme {
 public:
  /// Refers to the pattern, which outlives it; it has 4 unknowns at least.
  explicit LaneScheme(const Pattern& pattern);

  struct Stepping {
    double step, end;
    bool second_order = false;  ///< Start
  };
  /// Runs up to 16 bars from 0. @returns false where a matrix is not positive definite, in any lane
  bool run(std::span<const Member> bars, const Stepping& how, const LaneOutputs& outputs, LaneAccounts& accounts);

 private:
  /// The factor of a step's matrix, its rows eliminated from the far end to the near one.
  struct Elimination {
    std::vector<Lanes> multiplier, inverse_pivot, coupling, to_far;
    Lanes near_skip = 0.0, far_skip = 0.0;  // of y_2 in row 0, of x_{n-3} in row n-1, counted from the near end
  };

  void load_bars(std::span<const Member> bars);
  bool factorise(double damping, double elasticity, double lever);
  bool eliminate(bool right, double lever);
  void evaluate_load(double t);
  void finish(std::span<Lanes> x) const;
  void bound();
  /// Calls f with two constants, which of the ends have an obstacle, where any has.
  template <class F>
  void by_contacts(F&& f) const {
    if (pattern_.contact[0] && pattern_.contact[1])
      f(std::true_type(), std::true_type());
    else if (pattern_.contact[0])
      f(std::true_type(), std::false_type());
    else if (pattern_.contact[1])
      f(std::false_type(), std::true_type());
  }
  void react();
  template <bool on_left, bool on_right>
  void react_at();
  template <bool on_left, bool on_right, class V, class Get>
  void constrain(const std::array<V, 2>& excess, Get&& get, std::array<V, 2>& reaction, std::array<V, 2>& active) const;
  void sweep();
  void advance();
  template <bool right, bool moving, bool reacting, bool general>
  void pass();
  void start_from(bool second_order);
  void project_start();
  void settle_massless(bool right);
  static Lanes largest_of(const std::vector<Lanes>& field);
  void account(bool first, double whole, LaneAccounts& accounts);

  const Pattern& pattern_;
  std::size_t size_;
  double dt_ = 0.0;

  // Numbers of the bars.
  Lanes restitution_ = 0.0;
  std::array<Lanes, 2> gap_, spring_, dashpot_, mass_, wall_;
  Lanes inertia_, modulus_, viscosity_;       // rho L, E / L, eta / L
  Lanes scale_, inverse_scale_, relaxation_;  // E / h, or E / L on a graded mesh; eta / E
  const std::vector<LoadPart>* shared_load_ = nullptr;
  std::vector<const std::vector<LoadPart>*> own_loads_;
  bool loaded_ = false, varying_ = false, rebounds_ = false, graded_ = false, fields_ = false;

  // Factor of the step's matrix, towards the left and towards the right end.
  std::vector<Lanes> diagonal_, off_;
  std::array<Elimination, 2> eliminations_;
  std::array<std::vector<Lanes>, 2> column_;  // lever A^{-1} s e of a contact
  std::array<std::array<Lanes, 2>, 2> compliance_;
  std::array<Lanes, 2> inverse_compliance_;
  Lanes inverse_determinant_;

  // The step from n to n + 1: y is the force, eliminated towards the near end, x = dt a^n the kick.
  bool near_right_ = false;
  std::vector<Lanes> u_, p_, y_, load_, scaled_load_, x_, x_before_;
  std::array<Lanes, 2> lower_, bound_, reaction_{}, reaction_before_{}, start_impulse_, end_x_, end_x_before_;
  std::array<Lanes, 2> active_{}, was_active_{};  // 1 where an end is held, else 0
  bool changes_ = false;                          // some are not as they were
};

}  // namespace viscobar::bars
