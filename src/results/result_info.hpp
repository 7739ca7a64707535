#pragma once

#include <filesystem>
#include <string>

namespace viscobar {

/// What is in a directory of results: for each summary there (of a run, a comparison, a limit or precision study, or
/// the table of a sweep) what was computed, whether it is complete and its key numbers; and every file with its size.
/// Given one of the summaries, of that one alone. As one JSON document and for the terminal.
/// @throws std::invalid_argument when there is no result
/// @throws IoError when a summary cannot be read
std::string result_json(const std::filesystem::path& place);
std::string result_text(const std::filesystem::path& place);

}  // namespace viscobar
