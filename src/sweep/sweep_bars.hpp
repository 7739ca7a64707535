#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

/// Bars that a worker takes at a time at most. They are fewer where so many would take longer than a fifth of a second.
inline constexpr std::size_t most_bars_at_once = 512;
/// Columns of numbers that a row of bars may have: HDF5 describes all of them in one header of 64 KiB.
inline constexpr std::size_t most_bar_columns = 200;

/// Sets the columns, the common values and the batch of a sweep with outputs. Returns a key and a message for each
/// thing that is wrong.
std::vector<std::pair<std::string, std::string>> plan_bars(SweepFile& sweep);

/// The numbers that the varied keys have in a case.
std::vector<double> values_of_bar(const SweepPlan& plan, std::size_t index);
/// The case in which they have these.
Case case_of_bar(const SweepFile& sweep, std::span<const double> values);

/// A message that fits into a row.
std::string fitting(std::string text);

/// Rows of cases as an ensemble tells them, to the bit those of any other batch; fewer where `interrupted` says yes.
std::vector<SweepRow> run_bars(const SweepFile& sweep, std::span<const std::size_t> indices,
                               const std::function<bool()>& interrupted);

}  // namespace viscobar
