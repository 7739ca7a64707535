#include "report/write_page.hpp"

#include <system_error>

#include "results/output_file.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

std::string place_of(const FigureFile& figure) { return "figures/" + figure.name + ".svg"; }

FileChecksums checksums_of(const std::string& file, const PicturedPage& page) {
  FileChecksums files{{file, Checksum::of(page.html)}};
  for (const FigureFile& figure : page.figures) files[place_of(figure)] = Checksum::of(figure.svg);
  return files;
}

}  // namespace

FileChecksums write_page(const std::filesystem::path& directory, const std::string& file, const PicturedPage& page) {
  write_atomically(directory / file, page.html);
  if (!page.figures.empty()) {
    std::error_code error;
    std::filesystem::create_directories(directory / "figures", error);
    if (error) throw IoError(directory / "figures", "cannot be created: " + error.message());
  }
  for (const FigureFile& figure : page.figures) write_atomically(directory / place_of(figure), figure.svg);
  return checksums_of(file, page);
}

std::string write_study(const std::filesystem::path& directory, const std::string& name, const std::string& summary,
                        PicturedPage page, bool with_figures) {
  if (!with_figures) page.figures.clear();
  const std::string text = sealed_summary(summary, checksums_of(name + ".html", page));
  write_atomically(directory / (name + ".json"), text);
  write_page(directory, name + ".html", page);
  return text;
}

}  // namespace viscobar
