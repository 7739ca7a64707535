#include "results/sealed_summary.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

namespace viscobar {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view no_digits = "0000000000000000", before = "\"crc64\": \"", behind = "\"\n}\n";

}  // namespace

std::string sealed_summary(Json summary, const FileChecksums& files) {
  Json& list = summary["files"] = Json::object();
  for (const auto& [name, sum] : files) list[name] = {{"bytes", sum.bytes}, {"crc64", sum.digits()}};
  summary["crc64"] = no_digits;
  // Error texts may quote the user's file, which need not be valid UTF-8.
  std::string text = summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  text.replace(text.size() - behind.size() - no_digits.size(), no_digits.size(), Checksum::of(text).digits());
  return text;
}

std::string sealed_summary(const std::string& summary, const FileChecksums& files) {
  return sealed_summary(Json::parse(summary), files);
}

Seal seal_of(std::string_view text) {
  constexpr std::size_t length = before.size() + no_digits.size() + behind.size();
  const std::string_view seal = text.substr(text.size() - std::min(text.size(), length));
  if (seal.size() == length && seal.starts_with(before) && seal.ends_with(behind)) {
    Checksum sum = Checksum::of(text.substr(0, text.size() - no_digits.size() - behind.size()));
    sum.add(no_digits);
    sum.add(behind);
    return sum.digits() == seal.substr(before.size(), no_digits.size()) ? Seal::sound : Seal::broken;
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

}  // namespace viscobar
