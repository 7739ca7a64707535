#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "text/checksum.hpp"

namespace viscobar {

/// Files of a result, by their path within its directory.
using FileChecksums = std::map<std::string, Checksum>;

/// The text of a summary with its own checksum behind all else,
///
///     "crc64": that of this text with sixteen zeros in its place
///
/// which `text` has there.
std::string with_seal(std::string text);

enum class Seal {
  sound,
  broken,  ///< the text is not the one that was written
  absent   ///< there is none: of a version that did not make them
};
Seal seal_of(std::string_view text);

/// Those of a summary whose seal is sound.
FileChecksums files_of(std::string_view summary);

/// Refuses a file that lies in a result of a run and is not what was written there, `bytes` being its content. A file
/// elsewhere, one that the result does not name, and one of a run that is not at its end are taken as they are.
/// @throws SceneError
void check_unchanged(const std::filesystem::path& file, std::string_view bytes);

}  // namespace viscobar
