#include "io/page.hpp"

#include <fmt/format.h>

#include "io/plot/figure.hpp"
#include "scene/end_kinds.hpp"
#include "viscobar/io/versions.hpp"

namespace viscobar {

namespace {

using plot::escaped;
using plot::readable;

constexpr std::string_view page_css = R"css(
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); line-height: 1.5;
  font-family: system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "Liberation Sans", sans-serif; }
main { max-width: 1040px; margin: 0 auto; padding: 40px 24px 64px; }
header { margin-bottom: 28px; }
h1 { font-size: 1.75rem; line-height: 1.2; margin: 0 0 .5rem; font-weight: 650; letter-spacing: -.01em; }
h2 { font-size: 1.05rem; font-weight: 600; margin: 0 0 .75rem; }
.model { margin: 0; color: var(--soft); }
.model i, figcaption i { font-family: "STIX Two Text", "Cambria", "Liberation Serif", Georgia, serif; font-size: 1.05em; }
.failed { border-left: 4px solid var(--series-1); background: var(--paper); padding: 10px 16px; margin: 20px 0 0; }
section, figure { background: var(--paper); border: 1px solid var(--faint); border-radius: 8px; padding: 20px 24px;
  margin: 0 0 20px; }
figcaption { color: var(--soft); font-size: .875rem; margin-top: 8px; }
dl { display: grid; grid-template-columns: repeat(auto-fill, minmax(210px, 1fr)); gap: 14px 24px; margin: 0; }
dt { color: var(--soft); font-size: .8125rem; }
dd { margin: 0; font-size: 1.0625rem; font-variant-numeric: tabular-nums; }
dd small { display: block; line-height: 1.35; color: var(--soft); font-size: .8125rem; }
.tables { overflow-x: auto; }
table { border-collapse: collapse; font-size: .875rem; font-variant-numeric: tabular-nums; }
th { color: var(--soft); font-weight: 500; text-align: right; border-bottom: 1px solid var(--rule); }
th, td { padding: 4px 28px 4px 0; text-align: right; white-space: nowrap; }
th:first-child, td:first-child, .word { text-align: left; }
.wide th, .wide td { padding-right: 14px; }
.wide th:last-child, .wide td:last-child { padding-right: 0; }
tbody tr + tr td { border-top: 1px solid var(--faint); }
p.note { color: var(--soft); font-size: .875rem; margin: 10px 0 0; }
.verdict { border-left: 4px solid var(--series-2); background: var(--paper); padding: 10px 16px; margin: 20px 0 0; }
.verdict.plateau { border-color: var(--series-1); }
footer { color: var(--soft); font-size: .8125rem; }
@media print { body { background: none; } main { padding: 0; max-width: none; } section, figure { break-inside: avoid; } }
)css";

std::string end_text(EndCondition end) {
  const EndKind& kind = end_kind(end);
  std::string text(kind.in_words);
  for (const EndNumber& number : kind.numbers)
    text += fmt::format(", {}\u00a0{}", number.key, readable(number.of(end)));
  return text;
}

std::string grouped(std::size_t value) {
  std::string digits = fmt::format("{}", value);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, "\u2009");
  return digits;
}

}  // namespace

std::string model_html(const Scene& scene) {
  const Bar& bar = scene.bar;
  const bool damped = bar.viscosity > 0.0;
  std::string load = "0";
  if (scene.load)
    load = std::holds_alternative<SteadyLoad>(*scene.load) ? "<i>f</i>(<i>x</i>)" : "<i>f</i>(<i>x</i>, <i>t</i>)";
  std::string text = fmt::format(
      "<i>ρ u<sub>tt</sub></i> − <i>E u<sub>xx</sub></i>{} = {} on 0 &lt; <i>x</i> &lt; {}, with <i>ρ</i> = {}, "
      "<i>E</i> = {}{}. "
      "Left end {}; right end {}",
      damped ? " − <i>η u<sub>xxt</sub></i>" : "", load, readable(bar.length), readable(bar.density),
      readable(bar.modulus), damped ? ", <i>η</i> = " + readable(bar.viscosity) : "", end_text(scene.left),
      end_text(scene.right));
  if (scene.span)
    text += fmt::format("; under the whole span <i>u</i>\u00a0≥\u00a0{}",
                        readable(scene.span->gap == 0.0 ? 0.0 : -scene.span->gap));
  return text + ".";
}

void Numbers::add(std::string_view name, const std::string& value, std::string_view remark) {
  html_ += fmt::format("<div><dt>{}</dt><dd>{}", name, value);
  if (!remark.empty()) html_ += fmt::format(" <small>{}</small>", remark);
  html_ += "</dd></div>\n";
}

void Numbers::add(std::string_view name, std::size_t value) { add(name, grouped(value)); }

std::string Numbers::html(std::string_view heading) const {
  return fmt::format("<section><h2>{}</h2>\n<dl>\n{}</dl></section>\n", heading, html_);
}

std::string section_html(std::string_view heading, std::string_view content) {
  return fmt::format("<section><h2>{}</h2>\n{}</section>\n", heading, content);
}

std::string figure_html(std::string_view picture, std::string_view heading, std::string_view caption) {
  return fmt::format("<figure>\n<h2>{}</h2>\n{}<figcaption>{}</figcaption>\n</figure>\n", heading, picture, caption);
}

std::string page_html(std::string_view title, const Scene& scene, std::string_view head, std::string_view body) {
  const Versions used = versions();
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light "
      "dark\">\n<title>{0}</title>\n<style>{1}{2}</style>\n</head>\n<body>\n<main>\n"
      "<header>\n<h1>{0}</h1>\n<p class=\"model\">{3}</p>\n{4}</header>\n{5}"
      "<footer>viscobar {6}, SUNDIALS {7}, HDF5 {8}, Eigen {9}; {10}. All quantities in the units of the "
      "scene.</footer>\n"
      "</main>\n</body>\n</html>\n",
      escaped(title), plot::figure_css(), page_css, model_html(scene), head, body, used.viscobar, used.sundials,
      used.hdf5, used.eigen, escaped(used.platform));
}

}  // namespace viscobar
