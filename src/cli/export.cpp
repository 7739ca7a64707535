#include <algorithm>
#include <array>

#include "cli/commands.hpp"
#include "results/result_info.hpp"
#include "text/printable_text.hpp"

namespace viscobar::cli {

namespace {

struct ExportOptions {
  std::string directory, format = "csv", where;
  bool quiet = false;
};

int export_files(const ExportOptions& asked) {
  constexpr std::array known = {"csv", "xdmf"};
  constexpr ExportFormat formats[] = {ExportFormat::csv, ExportFormat::xdmf};
  const auto* format = std::ranges::find(known, asked.format);
  if (format == known.end())
    refuse("--format: there is no format \"{}\"{}", asked.format, instead_of(asked.format, known));
  std::filesystem::path target = asked.where;
  if (target.empty()) target = std::filesystem::path(asked.directory) / asked.format;
  catch_interrupts();
  try {
    for (const auto& file : export_result(asked.directory, formats[format - known.begin()], target, interrupt_asked))
      if (!asked.quiet) print(one_line(file.string()) + "\n");
  } catch (const ExportStopped&) {
    complain("interrupted; nothing was changed");
    return stopped;
  }
  return success;
}

}  // namespace

Action export_command(CLI::App& command) {
  const auto asked = std::make_shared<ExportOptions>();
  add(command, "directory", "DIR", asked->directory, "The directory of results of `viscobar run`")->required();
  add(command, "--format", "csv|xdmf", asked->format, "Of the files")->capture_default_str();
  add(command, "-o,--output", "DIR", asked->where,
      "Directory of the files; an earlier export there is replaced (default: DIR/csv or DIR/xdmf)");
  add_quiet(command, asked->quiet);
  return [asked] { return export_files(*asked); };
}

}  // namespace viscobar::cli
