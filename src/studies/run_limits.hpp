#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "viscobar/case/case.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"

namespace viscobar {

/// Runs of a study took longer than they may.
struct TooLong : std::runtime_error {
  explicit TooLong(const std::string& what = "takes too long") : std::runtime_error(what) {}
};

/// Bounds of a run of a study, looked at between steps.
struct RunLimits {
  std::function<bool()> stop;                                ///< true: the study is to end; may be empty
  double seconds = std::numeric_limits<double>::infinity();  ///< of processor time, which other work leaves alone
  std::size_t steps = std::numeric_limits<std::size_t>::max();
};

/// simulate() within limits; progress is theirs. @throws StudyStopped, TooLong, IntegrationError,
/// std::invalid_argument
Statistics simulate_within(const RunLimits& limits, const Setup& setup, const BarSystem& system,
                           std::span<const double> times, Observers observers);
/// The same on the output times of the setup.
Statistics simulate_within(const RunLimits& limits, const Setup& setup, const BarSystem& system, Observers observers);

/// Beyond this, dense matrix exponentials take longer than everything else together.
inline constexpr std::size_t most_exponential_elements = 100;

/// The first fault of a setup, "key: problem". Absent where there is none.
std::optional<std::string> fault_in_words(const Setup& setup);

}  // namespace viscobar
