#include "report/page.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "report/number_text.hpp"
#include "report/scene_check.hpp"
#include "report/scene_ends.hpp"
#include "results/file_set.hpp"
#include "results/output_file.hpp"
#include "scene/end_kinds.hpp"
#include "text/joined.hpp"
#include "text/json_text.hpp"
#include "text/number.hpp"
#include "text/printable_text.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

/// The files that pages are made of, embedded by cmake/embed.cmake.
namespace page_files {
extern const std::string_view style, script;  // src/report/web
}  // namespace page_files

namespace {

std::string end_text(EndCondition end, const EndInput& input, const Scene& scene) {
  const EndKind& kind = end_kind(end);
  const NumberText number = NumberText::page(scene);
  const auto of_key = [&](const char* key, double value) { return number.of_key(key, value, 4); };
  std::string text(kind.in_words);
  for (const EndNumber& one : kind.numbers)
    text += fmt::format(", {}\u00a0{}", one.key, number(one.of(end), unit_powers(one.unit).value_or(UnitPowers{}), 4));
  if (const auto* obstacle = std::get_if<Obstacle>(&end); obstacle && obstacle->side == Side::above) text += ", above";
  if (input.force)
    text += input.force->steady ? fmt::format(", force {}", number(input.force->value(0.0), Dimension::force, 4))
                                : ", force F(t)";
  if (input.motion) text += is_obstacle(end) ? ", moving" : ", motion d(t)";
  if (input.stiffness > 0.0) text += fmt::format(", spring {} to u = 0", of_key("left.stiffness", input.stiffness));
  if (input.dashpot > 0.0) text += fmt::format(", dashpot {}", of_key("left.dashpot", input.dashpot));
  if (input.stop) text += fmt::format(", a stop by {}", name(input.stop->law));
  if (input.mass > 0.0) text += fmt::format(", mass {}", of_key("left.mass", input.mass));
  return text;
}

std::string grouped(std::size_t value) {
  std::string digits = fmt::format("{}", value);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, "\u202f");
  return digits;
}

std::string figure_place(const std::string& name) { return "figures/" + name + ".svg"; }

FileChecksums checksums_of(const std::string& file, const PicturedPage& page) {
  FileChecksums files{{file, Checksum::of(page.html)}};
  for (const auto& [name, svg] : page.figures) files[figure_place(name)] = Checksum::of(svg);
  return files;
}

}  // namespace

std::string model_html(const Scene& scene) {
  const Bar& bar = scene.bar;
  const NumberText number = NumberText::page(scene);
  const auto of_key = [&](const char* key, double value) { return number.of_key(key, value, 4); };
  const std::string left = end_text(scene.left, scene.left_input, scene),
                    right = end_text(scene.right, scene.right_input, scene),
                    length = number(bar.length, Dimension::length, 4);
  if (!scene.chain.empty())
    return fmt::format("{} in line, <i>L</i> = {}: {}. Left end {}; right end {}.", scene.chain.size(), length,
                       fmt::format("{}", fmt::join(member_texts(scene, NumberText::For::page), "; ")), left, right);
  const bool damped = bar.viscosity > 0.0;
  std::string load = "0";
  if (scene.load)
    load = std::holds_alternative<SteadyLoad>(*scene.load) ? "<i>f</i>(<i>x</i>)" : "<i>f</i>(<i>x</i>, <i>t</i>)";
  const bool varies = static_cast<bool>(scene.section);
  const std::string stress =
      varies ? fmt::format("(<i>A</i> (<i>E u<sub>x</sub></i>{}))<sub><i>x</i></sub>",
                           damped ? " + <i>η u<sub>xt</sub></i>" : "")
             : fmt::format("<i>E u<sub>xx</sub></i>{}", damped ? " − <i>η u<sub>xxt</sub></i>" : "");
  const std::string_view area = varies ? "<i>A</i> " : "";
  const auto side = [&](bool there, std::string_view term) {
    return there ? fmt::format(" + {}<i>{}</i>", area, term) : "";
  };
  std::string text = fmt::format(
      "{}<i>ρ u<sub>tt</sub></i> − {}{}{} = {}{} on 0 &lt; <i>x</i> &lt; {}, with {}<i>ρ</i> = {}, <i>E</i> = {}{}. "
      "Left end {}; right end {}",
      area, stress, side(scene.side && scene.side->stiffness, "k u"),
      side(scene.side && scene.side->drag, "c u<sub>t</sub>"), scene.load ? area : "", load, length,
      varies ? "a section " + section_text(scene, NumberText::For::page) + ", " : "",
      of_key("bar.density", bar.density), of_key("bar.modulus", bar.modulus),
      damped ? ", <i>η</i> = " + of_key("bar.viscosity", bar.viscosity) : "", left, right);
  for (const ObstacleLevel& level : levels_of(scene.span))
    text += fmt::format("; {} the whole span <i>u</i>\u00a0{}\u00a0{}", level.above ? "above" : "under",
                        level.above ? "≤" : "≥", number(level.u, Dimension::length, 4));
  return text + ".";
}

void Numbers::add(std::string_view name, const std::string& value, std::string_view remark) {
  html_ += fmt::format("<div><dt>{}</dt><dd>{}", name, value);
  if (!remark.empty()) html_ += fmt::format(" <small>{}</small>", remark);
  html_ += "</dd></div>\n";
}

void Numbers::add(std::string_view name, std::size_t value) { add(name, grouped(value)); }

std::string Numbers::list() const { return joined({"<dl>\n", html_, "</dl>\n"}); }

std::string Numbers::html(std::string_view heading) const { return section_html(heading, list()); }

std::string section_html(std::string_view heading, std::string_view content) {
  return fmt::format("<section><h2>{}</h2>\n{}</section>\n", heading, content);
}

std::string sentence_html(std::string_view sentence) {
  const std::string text = escaped(with_readable_numbers(sentence));
  std::string html;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t hat = std::min(text.find('^', at), text.size());
    html.append(text, at, hat - at);
    if (hat == text.size()) break;
    // ^2.38, or ^(-1/2) without its brackets.
    const bool bracketed = text.substr(hat + 1).starts_with('(');
    const std::size_t from = hat + 1 + (bracketed ? 1 : 0);
    std::size_t to = bracketed ? text.find(')', from) : text.find_first_not_of("0123456789.", from);
    to = std::min(to, text.size());
    while (!bracketed && to > from && text[to - 1] == '.') --to;
    if (to == from)
      html += '^';
    else
      html += fmt::format("<sup>{}</sup>", with_true_minus(text.substr(from, to - from)));
    at = to + (bracketed && to < text.size() ? 1 : 0);
  }
  return html;
}

std::string notes_html(const std::vector<std::string>& sentences) {
  std::string html;
  for (const std::string& sentence : sentences)
    html += fmt::format("<p class=\"note\">{}.</p>\n", sentence_html(sentence));
  return html;
}

Page Page::of_study(const Scene& scene, std::string_view what) {
  return Page((scene.title.empty() ? "A scene" : scene.title) + std::string(what), scene);
}

void Page::add(Picture picture) {
  if (picture.panels.empty()) return;
  body_ += fmt::format("<figure>\n<h2>{}</h2>\n", picture.heading);
  for (Panel& panel : picture.panels) {
    body_ += joined(
        {"<div class=\"panel\" data-picture=\"", panel.name, "\">\n", panel.figure.svg(panel.title), "</div>\n"});
    panels_.push_back(std::move(panel));
  }
  body_ += fmt::format("<figcaption>{}</figcaption>\n</figure>\n", picture.caption);
}

void Page::fill_in(std::string_view mark, std::string_view text) {
  if (const std::size_t at = body_.find(mark); at != body_.npos) body_.replace(at, mark.size(), text);
}

void Page::add_data(std::string_view key, std::string_view json) {
  data_ += joined({data_.empty() ? "" : ",\n", plot::json_string(key), ":", json});
}

std::string Page::html() const {
  const Versions used = versions();
  const bool scripted = !panels_.empty() || !data_.empty();
  const auto with_script = [&](std::string_view text) { return scripted ? text : std::string_view(); };
  const std::string title = escaped(title_);
  return joined(
      {"<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
       "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>",
       title,
       "</title>\n<style>",
       plot::palette_css(),
       plot::drawing_css(),
       page_files::style,
       "</style>\n</head>\n<body>\n<main>\n<header>\n<h1>",
       title,
       "</h1>\n",
       model_.empty() ? "" : fmt::format("<p class=\"model\">{}</p>\n", model_),
       head_,
       "</header>\n",
       body_,
       fmt::format("<footer>viscobar {}, SUNDIALS {}, HDF5 {}, Eigen {}; {}. All quantities in the units of the "
                   "scene.</footer>\n</main>\n",
                   used.viscobar, used.sundials, used.hdf5, used.eigen, escaped(used.platform)),
       with_script("<script type=\"application/json\" id=\"data\">{"),
       data_,
       with_script("}</script>\n<script>(() => {\n\"use strict\";\n"),
       with_script(page_files::script),
       with_script("})();</script>\n"),
       "</body>\n</html>\n"});
}

PicturedPage Page::with_figures() const {
  PicturedPage page{html(), {}};
  for (const Panel& panel : panels_) page.figures.push_back({panel.name, panel.figure.file(panel.title)});
  return page;
}

FileChecksums write_page(const std::filesystem::path& directory, const std::string& file, const PicturedPage& page) {
  write_atomically(directory / file, page.html);
  if (!page.figures.empty()) make_directories(directory / "figures");
  for (const auto& [name, svg] : page.figures) write_atomically(directory / figure_place(name), svg);
  return checksums_of(file, page);
}

std::string write_study(const std::filesystem::path& directory, const std::string& name, const std::string& summary,
                        PicturedPage page, const StudyFiles& files) {
  if (!files.figures) page.figures.clear();
  FileSet set(directory, name);
  FileChecksums checksums = write_page(set.folder(), name + ".html", page);
  for (const auto& [table, text] : files.tables) {
    set.write(table, text);
    checksums[table] = Checksum::of(text);
  }
  const std::string text = sealed_summary(summary, checksums);
  set.write(name + ".json", text);
  set.take_places();
  return text;
}

}  // namespace viscobar
