#include "io/write_page.hpp"

#include <system_error>

#include "io/output_file.hpp"
#include "viscobar/io/io_error.hpp"

namespace viscobar {

void write_figures(const std::filesystem::path& directory, const std::vector<FigureFile>& figures) {
  const std::filesystem::path folder = directory / "figures";
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw IoError(folder, "cannot be created: " + error.message());
  for (const FigureFile& figure : figures) write_atomically(folder / (figure.name + ".svg"), figure.svg);
}

void write_page(const std::filesystem::path& directory, std::string_view file, const PicturedPage& page,
                bool with_figures) {
  write_atomically(directory / file, page.html);
  if (with_figures) write_figures(directory, page.figures);
}

}  // namespace viscobar
