#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "results/checkpoint_file.hpp"
#include "results/json.hpp"
#include "results/result_directory.hpp"
#include "results/result_info.hpp"
#include "results/summary.hpp"
#include "results/sweep_frame.hpp"
#include "text/printable_text.hpp"
#include "text/table.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

/// Checksums that are known of the files of a directory. A file that several summaries tell of, as a picture that a
/// later study replaced, is sound when it is what one of them says.
class Verification {
 public:
  explicit Verification(const fs::path& directory) : directory_(directory) {
    const auto there = [&](std::string_view name) { return fs::exists(directory / name); };
    if (std::ranges::none_of(result_kinds(), there, &ResultFiles::summary) && !there("sweep.h5"))
      throw std::invalid_argument(directory.string() + " holds no result of viscobar");
    for (const fs::path& folder : {directory, directory / "figures"})
      if (fs::is_directory(folder))
        for (const auto& entry : fs::directory_iterator(folder))
          if (entry.is_regular_file()) found_[fs::relative(entry.path(), directory).string()].bytes = entry.file_size();
    for (const ResultFiles& files : result_kinds()) {
      const std::string name(files.summary);
      if (found_.contains(name))
        summary(name);
      else if (there(name))
        tell(name, FileState::damaged, "it is no file");
    }
    if (found_.contains("sweep.h5"))
      sweep();
    else if (found_.contains("sweep.json"))
      tell("sweep.h5", FileState::missing, "it has the rows of sweep.json");
    if (found_.contains("summary.json")) unfinished_run();
  }

  std::vector<VerifiedFile> files() {
    std::vector<VerifiedFile> all;
    for (auto& [name, file] : found_) {
      file.name = name;
      all.push_back(file);
    }
    return all;
  }

 private:
  void tell(const std::string& name, FileState state, const std::string& reason = "") {
    VerifiedFile& file = found_[name];
    if (file.state == FileState::sound) return;
    file.state = state;
    file.reason = reason;
  }

  void compare(const std::string& name, const Checksum& expected) {
    const auto file = found_.find(name);
    if (file == found_.end() || file->second.state == FileState::missing)
      return tell(name, FileState::missing, "the summary names it");
    if (file->second.bytes != expected.bytes)
      return tell(name, FileState::damaged, fmt::format("{} bytes were written", expected.bytes));
    if (checksum_of_file(directory_ / name) != expected)
      return tell(name, FileState::damaged, "its checksum is not the one that was written");
    tell(name, FileState::sound);
  }

  void summary(const std::string& name) {
    const std::string text = file_content(directory_ / name);
    switch (seal_of(text)) {
      case Seal::broken: return tell(name, FileState::damaged, "its checksum is not the one that was written");
      case Seal::absent: return tell(name, FileState::unchecked, "of a version that made no checksums");
      case Seal::sound: break;
    }
    tell(name, FileState::sound);
    for (const auto& [file, sum] : files_of(text)) compare(file, sum);
    if (name == "sweep.json") rows_at_the_end_ = Json::parse(text).value("done", std::size_t{0});
  }

  void sweep() {
    const fs::path file = directory_ / "sweep.h5";
    try {
      const std::optional<SweepFrame> frame = SweepFrame::read(file);
      if (!frame) return tell("sweep.h5", FileState::unchecked, "of a version that made no checksums");
      const SweepRowStates rows = check_rows(file, *frame);
      if (!rows.damaged.empty())
        return tell("sweep.h5", FileState::damaged,
                    fmt::format("rows of {} cases are not what was written: {}", rows.damaged.size(),
                                fmt::join(std::span(rows.damaged).first(std::min<std::size_t>(rows.damaged.size(), 10)),
                                          ", ")));
      if (rows.done < rows_at_the_end_)
        return tell(
            "sweep.h5", FileState::damaged,
            fmt::format("{} rows are marked as done, {} were at the end of the sweep", rows.done, rows_at_the_end_));
      tell("sweep.h5", FileState::sound, fmt::format("{} rows of {}", rows.done, frame->cases()));
    } catch (const IoError& error) {
      tell("sweep.h5", FileState::damaged, error.what());
    }
    for (const char* table : {"sweep.csv", "timings.csv"})
      if (found_.contains(table) && found_[table].state == FileState::foreign)
        tell(table, FileState::unchecked, "the sweep is not at its end");
  }

  // The growing files have no checksum in the summary of a run that is going on or was killed.
  void unfinished_run() {
    const VerifiedFile& told = found_["summary.json"];
    const std::string unknown = told.state == FileState::sound     ? "the run is not at its end"
                                : told.state == FileState::damaged ? "the summary, which has its checksum, is damaged"
                                                                   : told.reason;
    std::optional<RunCheckpoint> checkpoint;
    for (const char* name : {"checkpoint.bin", "checkpoint.previous.bin"}) {
      if (!found_.contains(name)) continue;
      const std::string bytes = file_content(directory_ / name);
      try {
        unsealed(bytes);
      } catch (const ArchiveError& error) {
        tell(name, FileState::damaged, error.what());
        continue;
      }
      tell(name, FileState::sound);
      try {
        if (!checkpoint) checkpoint = decoded(bytes);
      } catch (const ArchiveError& error) {
        tell(name, FileState::sound, error.what());
      }
    }
    const auto growing = [&](const char* name, bool marked, auto&& check) {
      if (found_.contains(name) && found_[name].state != FileState::foreign) return;
      if (!marked) {
        if (found_.contains(name)) tell(name, FileState::unchecked, unknown);
        return;
      }
      try {
        check();
        tell(name, FileState::sound, fmt::format("up to the checkpoint at t = {:.6g}", checkpoint->motion->time));
      } catch (const IoError& error) {
        tell(name, found_.contains(name) ? FileState::damaged : FileState::missing, error.what());
      }
    };
    const GrowingFiles::Mark marks = checkpoint ? checkpoint->files : GrowingFiles::Mark{};
    for (std::size_t k = 0; k < marks.tables.size(); ++k)
      growing(GrowingFiles::names[k], marks.tables[k].has_value(),
              [&] { check_begin(directory_ / GrowingFiles::names[k], *marks.tables[k]); });
    growing("field.h5", marks.field.has_value(), [&] { marks.field->check_values(directory_ / "field.h5"); });
    for (const char* name : {"field.xdmf", "report.html"})
      if (found_.contains(name) && found_[name].state == FileState::foreign) tell(name, FileState::unchecked, unknown);
  }

  const fs::path directory_;
  std::map<std::string, VerifiedFile> found_;
  std::size_t rows_at_the_end_ = 0;
};

constexpr std::string_view word(FileState state) {
  switch (state) {
    case FileState::sound: return "sound";
    case FileState::damaged: return "damaged";
    case FileState::missing: return "missing";
    case FileState::unchecked: return "not checkable";
    case FileState::foreign: return "not of the result";
  }
  return {};
}

}  // namespace

std::vector<VerifiedFile> verify_result(const fs::path& directory) {
  if (!fs::is_directory(directory))
    throw std::invalid_argument(fmt::format("{} is no directory of results", directory.string()));
  settle_result_directory(directory);
  std::vector<VerifiedFile> files = Verification(directory).files();
  // A later run is unfinished beside a whole result.
  if (fs::exists(directory / "unfinished/summary.json"))
    for (VerifiedFile& file : Verification(directory / "unfinished").files()) {
      file.name.insert(0, "unfinished/");
      files.push_back(std::move(file));
    }
  return files;
}

void check_sound(const fs::path& directory, std::string_view done) {
  for (const VerifiedFile& file : verify_result(directory))
    if ((file.state == FileState::damaged || file.state == FileState::missing) && !file.name.starts_with("unfinished/"))
      throw IoError(directory / file.name, fmt::format("is {}{}{}; nothing was {}", word(file.state),
                                                       file.reason.empty() ? "" : ": ", file.reason, done));
}

FileState verdict(const std::vector<VerifiedFile>& files) {
  const auto some = [&](FileState state) {
    return std::ranges::any_of(files, [&](const VerifiedFile& file) { return file.state == state; });
  };
  if (some(FileState::damaged) || some(FileState::missing)) return FileState::damaged;
  return some(FileState::unchecked) ? FileState::unchecked : FileState::sound;
}

std::string verification_json(const fs::path& directory, const std::vector<VerifiedFile>& files) {
  Json json = {{"directory", directory.string()}, {"verdict", word(verdict(files))}, {"files", Json::array()}};
  for (const VerifiedFile& file : files) {
    json["files"].push_back({{"name", file.name}, {"bytes", file.bytes}, {"state", word(file.state)}});
    if (!file.reason.empty()) json["files"].back()["reason"] = file.reason;
  }
  return json_text(json);
}

std::string verification_text(const fs::path& directory, const std::vector<VerifiedFile>& files) {
  Table table{{"file", "state", "size"}, 2, {}};
  for (const VerifiedFile& file : files)
    table.rows.push_back({one_line(file.name), std::string(word(file.state)),
                          file.state == FileState::missing ? "" : byte_number(static_cast<double>(file.bytes))});
  std::string out = fmt::format("{}: {}\n\n", one_line(directory.string()), word(verdict(files))) + text(table);
  for (const VerifiedFile& file : files)
    if (!file.reason.empty()) out += fmt::format("  {}: {}\n", one_line(file.name), one_line(file.reason));
  return out;
}

}  // namespace viscobar
