#include "input/seal.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <system_error>

#include "input/input_text.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view seal_zeros = "0000000000000000", seal_begin = "\"crc64\": \"", seal_end = "\"\n}\n";

}  // namespace

std::string with_seal(std::string text) {
  return text.replace(text.size() - seal_end.size() - seal_zeros.size(), seal_zeros.size(),
                      Checksum::of(text).digits());
}

Seal seal_of(std::string_view text) {
  constexpr std::size_t length = seal_begin.size() + seal_zeros.size() + seal_end.size();
  const std::string_view seal = text.substr(text.size() - std::min(text.size(), length));
  if (seal.size() == length && seal.starts_with(seal_begin) && seal.ends_with(seal_end)) {
    Checksum sum = Checksum::of(text.substr(0, text.size() - seal_zeros.size() - seal_end.size()));
    sum.add(seal_zeros);
    sum.add(seal_end);
    return sum.digits() == seal.substr(seal_begin.size(), seal_zeros.size()) ? Seal::sound : Seal::broken;
  }
  // Damage in one place may hide the seal, not also the list of files before it.
  const Json read = Json::parse(text, nullptr, false);
  return read.is_object() && !read.contains("files") ? Seal::absent : Seal::broken;
}

FileChecksums files_of(std::string_view summary) {
  FileChecksums files;
  const Json read = Json::parse(summary);
  for (const auto& [name, entry] : read.at("files").items()) {
    Checksum& sum = files[name];
    sum.bytes = entry.at("bytes");
    const std::string digits = entry.at("crc64");
    std::from_chars(digits.data(), digits.data() + digits.size(), sum.crc64, 16);
  }
  return files;
}

void check_unchanged(const std::filesystem::path& file, std::string_view bytes) {
  const std::filesystem::path summary = file.parent_path() / "summary.json";
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(summary, unknown)) return;
  const auto refuse = [&](const std::filesystem::path& damaged) {
    throw SceneError({{damaged.string(), 1, 1, "",
                       "is damaged: its checksum is not the one that was written, as `viscobar info --verify` tells; a "
                       "table that was changed on purpose is taken outside of the result"}});
  };
  const std::string text = input_text(summary, std::size_t{1} << 30);
  if (text.find("\"method_requested\"") == text.npos && text.find(seal_begin) == text.npos)
    return;  // of another program
  const Seal seal = seal_of(text);
  if (seal == Seal::broken) refuse(summary);
  if (seal == Seal::absent) return;
  const FileChecksums files = files_of(text);
  const auto written = files.find(file.filename().string());
  if (written != files.end() && Checksum::of(bytes) != written->second) refuse(file);
}

}  // namespace viscobar
