#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

/// The part of "3/16". @throws std::invalid_argument for other texts
SweepPart part_of(std::string_view text);
/// The part of this process of a job of mpirun, srun or a like, by the variables that those set; absent: of none.
std::optional<SweepPart> part_in_job();

/// Rows of the same sweep in the results of others below `directory`, that of the whole sweep: of all parts; for one of
/// several parts those of the whole, and of parts of other numbers. Files that cannot be read go to `complain`.
/// @throws std::invalid_argument where one of them holds another sweep
std::vector<SweepRow> rows_beside(const std::filesystem::path& directory, const SweepFile& sweep, const SweepPart& part,
                                  const std::function<void(const std::string&)>& complain);

/// True if each of so many parts of a sweep has ended with all rows of its own.
bool are_whole(const std::filesystem::path& directory, std::size_t parts, const SweepPlan& plan);

}  // namespace viscobar
