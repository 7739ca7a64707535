#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/plot/figure.hpp"
#include "results/summary.hpp"
#include "viscobar/report/reports.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// The scene's equation and ends in a sentence.
std::string model_html(const Scene& scene);

std::string section_html(std::string_view heading, std::string_view content);

/// A sentence of the program as HTML, its numbers and powers as the page writes them.
std::string sentence_html(std::string_view sentence);

/// Remarks, sentences without their full stops, below each other.
std::string notes_html(const std::vector<std::string>& sentences);

/// Named values in columns.
class Numbers {
 public:
  void add(std::string_view name, const std::string& value, std::string_view remark = {});
  void add(std::string_view name, std::size_t value);
  std::string list() const;
  /// A card of them.
  std::string html(std::string_view heading) const;

 private:
  std::string html_;
};

/// A figure of a page, and of the file figures/NAME.svg.
struct Panel {
  std::string name;   ///< unique in its page
  std::string title;  ///< read out in place of the picture
  plot::Figure figure;
};

/// Figures below each other, with their heading and their caption (both HTML). Without panels it is not there.
struct Picture {
  std::string heading, caption;
  std::vector<Panel> panels = {};
};

/// A page of HTML that needs no other file and no network: the title, the equation of the scene, what was added, in its
/// order, and a footer with the versions. Its pictures are SVG; a script zooms them and reads numbers off them, and
/// what moves it draws from one JSON document in the page, {KEY: ...}.
class Page {
 public:
  Page(std::string title, const Scene& scene) : title_(std::move(title)), model_(model_html(scene)) {}
  explicit Page(std::string title) : title_(std::move(title)) {}
  /// "TITLE: the penalty limit"
  static Page of_study(const Scene& scene, std::string_view what);

  /// HTML below the equation.
  void add_head(std::string_view html) { head_ += html; }
  void add(std::string_view html) { body_ += html; }
  void add(Picture picture);
  void add_section(std::string_view heading, std::string_view content) { add(section_html(heading, content)); }
  /// Fills in what was not known before the page was made: the words `mark` in what has been added.
  void fill_in(std::string_view mark, std::string_view text);
  /// A further member of the document that the script reads.
  void add_data(std::string_view key, std::string_view json);

  std::string html() const;
  PicturedPage with_figures() const;

 private:
  std::string title_, model_, head_, body_, data_;
  std::vector<Panel> panels_;
};

/// Writes DIR/FILE, and DIR/figures/NAME.svg for each figure; returns their checksums. @throws IoError
FileChecksums write_page(const std::filesystem::path& directory, const std::string& file, const PicturedPage& page);

/// Beside the page and the summary of a study: whether its figures are wanted, and tables by their names.
struct StudyFiles {
  bool figures = false;
  std::map<std::string, std::string> tables{};
};

/// Replaces DIR/NAME.json, with the checksums of the files of the study, DIR/NAME.html and `files` together; returns
/// the text of the first. @throws IoError
std::string write_study(const std::filesystem::path& directory, const std::string& name, const std::string& summary,
                        PicturedPage page, const StudyFiles& files);

}  // namespace viscobar
