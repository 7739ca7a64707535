#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "studies/ensemble/bar_values.hpp"

namespace viscobar::bars {

/// A bar as it is told: its values, the estimate of their error (NaN: none) and the steps of its run.
struct Told {
  std::unique_ptr<BarValues> values;
  double error;
  std::size_t steps;
};

/// Runs a bar by the method of its setup, which is sound; with a wanted error at tolerances ten times apart, which the
/// setup is given, until the difference of two runs allows it. @throws StudyStopped @throws IntegrationError
Told run_alone(Setup& setup, const Layout& layout, std::optional<double> error, const std::function<bool()>& stop);

}  // namespace viscobar::bars
