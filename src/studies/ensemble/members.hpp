#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "schemes/lane_scheme.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar::bars {

/// A bar for lanes, with the data that are its own.
struct OwnMember {
  Member member;
  std::unique_ptr<State> start{};                 // null: shared, or the data
  std::unique_ptr<State> data{};                  // null: shared
  std::unique_ptr<std::vector<LoadPart>> load{};  // null: shared, or none
};

/// Makes the bars of an ensemble ready for lanes. A number that moves no data, such as bar.viscosity or left.gap, is
/// set in the case's own numbers; else the model makes the case anew.
class Members {
 public:
  /// @param first the case of the first bar, sound
  Members(const Case& first, Mass mass, std::vector<std::string> keys);

  /// Null where no bar of this scene can be in lanes.
  const Pattern* pattern() const { return pattern_ ? &*pattern_ : nullptr; }
  /// The bar with these values by its numbers alone; absent where the model has to make its case. `numbers` is a copy
  /// of the first case, in which they are set.
  std::optional<OwnMember> by_numbers(Case& numbers, std::span<const double> values) const;
  /// The bar of a sound case; absent where it does not fit into lanes with the others.
  std::optional<OwnMember> of(const Case& run) const;

 private:
  std::optional<Pattern> pattern_of(const Case& run) const;

  Mass mass_;
  double end_;
  std::vector<std::string> keys_;
  std::optional<Pattern> pattern_;
  OwnMember first_;
  bool by_numbers_ = false, resting_shape_ = false;
  State unit_velocity_, unit_displacement_;  // of initial data that are 1
  std::size_t elements_;
};

}  // namespace viscobar::bars
