#pragma once

#include <filesystem>

namespace viscobar {

/// Creates a directory for results where it is not there. An earlier result in it may be replaced, other files may not
/// be joined by ours. @throws std::invalid_argument when it holds files and none of viscobar's summaries
/// @throws IoError
void prepare_result_directory(const std::filesystem::path& directory);

}  // namespace viscobar
