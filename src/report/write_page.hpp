#pragma once

#include <filesystem>
#include <string>

#include "results/sealed_summary.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar {

/// Writes DIR/FILE, and DIR/figures/NAME.svg for each figure; returns their checksums. @throws IoError
FileChecksums write_page(const std::filesystem::path& directory, const std::string& file, const PicturedPage& page);

/// Writes DIR/NAME.json, with the checksums of the files of the study, and DIR/NAME.html, figures where they are
/// wanted; returns the text of the former. @throws IoError
std::string write_study(const std::filesystem::path& directory, const std::string& name, const std::string& summary,
                        PicturedPage page, bool with_figures);

}  // namespace viscobar
