#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace viscobar {

/// Slope p of y ~ C x^p by least squares on logarithms, with its standard error (from the scatter of the points about
/// the line; 0 for two points, where there is none).
struct ObservedOrder {
  double order = 0.0;           ///< p
  double standard_error = 0.0;  ///< of p
};

/// Absent for fewer than two usable points (both coordinates positive and finite).
std::optional<ObservedOrder> observed_order(std::span<const double> x, std::span<const double> y);

/// Errors e = C x^p at x_0 > x_1 > x_2, r_1 = x_0 / x_1 and r_2 = x_1 / x_2: by how much their changes fall,
///
///     (e_0 - e_1) / (e_1 - e_2)  =  (r_1^p - 1) / (1 - r_2^-p),      which grows with p and is r^p for r_1 = r_2 = r.
double fall_of_changes(double r_1, double r_2, double p);
/// The p of the changes e_0 - e_1 and e_1 - e_2; absent: one is not positive and finite.
std::optional<double> power_of_changes(double r_1, double r_2, double first, double second);

/// The power p of d ~ C x^p over a range of a sequence, and how far it may be from the power for x -> 0.
struct SequenceOrder : ObservedOrder {
  double bound = 0.0;     ///< of the error of p
  std::size_t first = 0;  ///< index of the first value of the range
  std::size_t last = 0;   ///< and of its last one
};

/// Distances d(x) to a limit, x a penalty, a step or a mesh size that decreases to 0.
///
/// A distance tells a power where it is ten times its floor, what else is in it: the other sequence, tolerances,
/// rounding. Between neighbours the power is p_i = log(d_i / d_{i+1}) / log(x_i / x_{i+1}). A range settles where two
/// p_i or more agree to `within`, two only where the one before them is not another. Its power is the slope of all of
/// it. Its bound is twice the slope's standard error, or how far the power of its last half lies from it, or what the
/// floors may do, or where the p_i drift to, by more than the floors may do, whichever is largest. Powers that drift
/// to one side do so as slowly as those of x^p log(1/x), p_k = p - c / (k + k_0), of which three, those of the
/// thirds of the range, tell
///
///     |p - p_k|  =  |p_k - p_{k-1}| (1 + 2 / (r - 1)),      r = (p_{k-1} - p_{k-2}) / (p_k - p_{k-1}).
///
/// It is told where the bound is `within` at most. Changes between neighbours of equal ratios fall with the power of
/// the errors, and are distances, too.
struct Sequence {
  static constexpr double by_few = 0.2;  ///< how closely three or four meshes or steps can tell an order

  std::vector<double> x;         ///< decreasing, > 0
  std::vector<double> distance;  ///< >= 0
  std::vector<double> floor;     ///< contribution of other errors to each distance, >= 0
  double within = 0.04;          ///< how closely an order is to be told

  /// One more value.
  void add(double at, double value, double otherwise) {
    x.push_back(at);
    distance.push_back(value);
    floor.push_back(otherwise);
  }
  /// Ranges that settle, each the largest from where the one before it ended, x decreasing. Two of them are two
  /// regimes.
  std::vector<SequenceOrder> settled() const;
  /// The largest settled range that ends with the smallest distance above its floor: that of the limit x -> 0. Absent:
  /// not settled.
  std::optional<SequenceOrder> order() const;
  /// Order of distances to a run near the limit, where those to the limit itself have the order `nearer`: the slope
  /// over the part of its range that is above the floor. They know no more of x -> 0 than that.
  std::optional<SequenceOrder> order_within(const std::optional<SequenceOrder>& nearer) const;
  /// True if the distances are seen to fall to 0: the last is within ten floors, or the last three, over half a decade
  /// of x or more, fall with a quarter of the power `theory` or more, each below the one before it.
  bool falls(double theory) const;
  /// p_i, settled or not; absent: there is no value i + 1, or a distance is 0.
  std::optional<double> power(std::size_t i) const;
  /// The first i with distances i and i + 1 that enclose `level`, the latter above its floor; absent: none do.
  std::optional<std::size_t> around(double level) const;
  /// The x there at which the distance is `level`, by the power p_i.
  std::optional<double> where(double level) const;
  /// The smallest x whose distance is ten times its floor; absent: there is none.
  std::optional<std::size_t> last_told() const;
};

}  // namespace viscobar
