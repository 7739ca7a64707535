#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "cli/commands.hpp"
#include "results/result_info.hpp"
#include "text/printable_text.hpp"

namespace viscobar::cli {

ExportCommand::ExportCommand(CLI::App& app)
    : Command(app, "export", "Write the field and the end traces of a run as CSV, NumPy arrays or XDMF") {
  command_.add_option("directory", directory_, "The directory of results of `viscobar run`")
      ->required()
      ->type_name("DIR");
  command_.add_option("--format", format_, "Of the files")->type_name("csv|npy|xdmf")->capture_default_str();
  command_
      .add_option("-o,--output", where_,
                  "Directory of the files; an earlier export there is replaced (default: DIR/csv, DIR/npy or DIR/xdmf)")
      ->type_name("DIR");
  add_quiet(command_, quiet_);
}

int ExportCommand::operator()() const {
  const std::vector<std::string_view> known = {"csv", "npy", "xdmf"};
  if (std::ranges::find(known, format_) == known.end())
    throw std::invalid_argument(
        fmt::format("--format: there is no format \"{}\"{}", format_, instead_of(format_, known)));
  const std::filesystem::path target =
      where_.empty() ? std::filesystem::path(directory_) / format_ : std::filesystem::path(where_);
  const ExportFormat format = format_ == "csv"   ? ExportFormat::csv
                              : format_ == "npy" ? ExportFormat::npy
                                                 : ExportFormat::xdmf;
  const auto files = export_result(directory_, format, target);
  if (!quiet_)
    for (const auto& file : files) print(one_line(file.string()) + "\n");
  return success;
}

}  // namespace viscobar::cli
