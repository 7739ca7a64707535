#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace viscobar {

/// What the table of a sweep holds, read off the file alone: cases, rows done, failed and remaining, the errors with
/// their numbers, the time spent, the smallest and largest value of each column (of numbers; the values of a text),
/// over the rows that are done. Also of a sweep that is running.
/// @throws IoError when the file is no table of a sweep
nlohmann::ordered_json sweep_facts(const std::filesystem::path& file);

}  // namespace viscobar
