#pragma once

#include <string>
#include <string_view>

#include "scene/unit_names.hpp"

namespace viscobar {

/// How a report writes its numbers: 1.23e-05 for the terminal, powers of ten on a page, with units where the scene
/// names them.
class NumberText {
 public:
  enum class For { terminal, page };
  NumberText(For reader, const Scene& scene);
  static NumberText terminal(const Scene& scene = {}) { return {For::terminal, scene}; }
  static NumberText page(const Scene& scene) { return {For::page, scene}; }

  std::string operator()(double value, int digits = 3) const;
  /// "1.25 m/s"; without a unit the number alone.
  std::string operator()(double value, const UnitPowers& unit, int digits = 3) const;
  std::string operator()(double value, Dimension quantity, int digits = 3) const {
    return (*this)(value, unit_powers(quantity), digits);
  }
  /// The value of a key of the scene.
  std::string of_key(std::string_view key, double value, int digits) const {
    return (*this)(value, unit_of(key), digits);
  }
  /// "time t [s]"; without a unit the words alone.
  std::string heading(std::string_view words, const UnitPowers& powers) const { return with_unit(words, unit(powers)); }
  std::string heading(std::string_view words, Dimension quantity) const {
    return heading(words, unit_powers(quantity));
  }

  /// A penalty: "0.001 m/N", and both units where it acts at the ends and along the span.
  std::string epsilon(double value, int digits) const;

  std::string unit(const UnitPowers& powers) const;  ///< empty where the scene does not name it
  UnitPowers unit_of(std::string_view key) const;    ///< of a key of the scene; of none where it has none

  UnitPowers of_epsilon;  ///< the unit of epsilon; of none where it has several

 private:
  For reader_;
  Units units_;
};

}  // namespace viscobar
