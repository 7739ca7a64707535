#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "characteristics/function_of_time.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {

enum class Interpolation { linear, cubic };
/// A series before its first and behind its last value: its own continuation (of a run, a scheme looks a step ahead),
/// that value, or 0.
enum class Outside { goes_on, hold, zero };

/// A function of time, or of x, through measured values: lines between them, or a cubic spline, whose slopes at both
/// ends are those of the cubics through the four values there (all, where there are fewer). Between values h apart the
/// spline differs from a smooth f by h^4 |f|, its second derivative by h^2 |f|, each times a constant of about
/// 0.01 and 0.1. It is twice differentiable but beside jumps and kinks of the values: there its slopes are limited, so
/// that it rises, falls and stays where the values do. Two values of one place are a jump: the second holds from there
/// on.
class Series {
 public:
  /// Places in order; no more than two are equal, and of a cubic none. At least one.
  Series(std::vector<double> places, std::vector<double> values, Interpolation interpolation, Outside outside);

  /// The value, or its first or second derivative.
  double operator()(double s, int derivative = 0) const;
  /// Where a step ends: at jumps and kinks; with a load also where its second derivative jumps, and where a stretch
  /// ends that a step might span without seeing what the function does in it; with a motion, whose load is its second
  /// derivative, also at that one's kinks.
  enum class Breaks { kinks, of_load, of_motion };
  /// The first of them in (after, until); absent: none there.
  std::optional<double> next_break(double after, double until, Breaks which) const;

  double first() const { return places_.front(); }  ///< place
  double last() const { return places_.back(); }    ///< place
  bool smooth() const { return interpolation_ == Interpolation::cubic; }
  std::uint64_t checksum() const;  ///< of places and values

 private:
  void find_slopes();
  void find_breaks();
  double chord(std::size_t k) const {  // its slope, from k to the next
    return (values_[k + 1] - values_[k]) / (places_[k + 1] - places_[k]);
  }

  std::vector<double> places_, values_, slopes_;  // the latter of a cubic
  std::array<std::vector<double>, 3> breaks_;     // by Breaks
  Interpolation interpolation_;
  Outside outside_;
};

/// Series as a scene gives it, { file = "record.csv", column = "F" } or { t = [...], values = [...] }:
///
///     file           a table of measured values, see TraceFile; from the folder of the scene
///     column         name of the values
///     t, x           name of the column of the places ("t" or "x"), or the places themselves
///     values         with those: the values
///     interpolation  "cubic" or "linear"; absent: cubic
///     scale          what the values are multiplied by, whatever their unit
///     outside        "hold" or "zero": what holds before and behind the values; absent: it goes on as it does beside
///     checksum       of a file that has been read, as a result tells it
struct SeriesRequest {
  char variable = 't';           ///< or 'x'
  bool jumps = true;             ///< allowed
  std::string unit, place_unit;  ///< that the scene names for them; empty: none
  bool names_units = false;      ///< the scene, of some quantity: then a unit of a file is not passed over
  std::filesystem::path folder;
};
/// @throws std::invalid_argument with what is wrong; SceneError of the file
std::shared_ptr<const Series> series_of(const SceneTable& table, const SeriesRequest& request);

/// The motion of an end or an obstacle.
characteristics::FunctionOfTime function_of(std::shared_ptr<const Series> series);

}  // namespace viscobar
