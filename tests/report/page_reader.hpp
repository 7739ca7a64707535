#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "support/scratch.hpp"
#include "viscobar/record/record_run.hpp"

namespace viscobar {

/// A page without its scripts.
inline std::string without_scripts(const std::string& html) {
  std::string out;
  for (std::size_t at = 0; at != html.npos;) {
    const std::size_t script = html.find("<script", at);
    out += html.substr(at, script - at);
    at = script == html.npos ? script : html.find("</script>", script);
  }
  return out;
}

/// A page as written.
struct Html {
  std::string html;
  /// Without its scripts, which know more words than the page says.
  bool has(const std::string& text) const { return without_scripts(html).find(text) != std::string::npos; }
};

inline Html page(const SceneFile& scene) {
  const Scratch scratch;
  record_run(scene, scratch.path());
  return {read_text(scratch / "report.html")};
}

/// The document that the page's script reads.
inline nlohmann::json data_of(const Html& page) {
  const std::string opening = "<script type=\"application/json\" id=\"data\">";
  const std::size_t begin = page.html.find(opening) + opening.size(), end = page.html.find("</script>", begin);
  return nlohmann::json::parse(page.html.substr(begin, end - begin));
}

/// The text between two others, behind a third.
inline std::string between(const std::string& html, const std::string& behind, const std::string& opening,
                           const std::string& closing) {
  const std::size_t from = html.find(opening, html.find(behind)), begin = from + opening.size();
  return from == html.npos ? "" : html.substr(begin, html.find(closing, begin) - begin);
}

/// The largest size of what a line of a picture shows: its path lies in a frame that is as high as the axis.
inline double largest_of(const Html& page, const std::string& name, const std::string& label) {
  const std::string svg = between(page.html, "data-picture=\"" + name + '"', "<svg ", "<g class=\"legend\">");
  std::string axis = between(svg, "", "data-y=\"", "\"");
  for (std::size_t at; (at = axis.find("&quot;")) != axis.npos;) axis.replace(at, 6, "\"");
  const nlohmann::json y = nlohmann::json::parse(axis);
  double left = 0.0, top = 0.0, width = 0.0, height = 0.0, most = 0.0, value = 0.0;
  std::istringstream(between(svg, "<svg x=", "viewBox=\"", "\"")) >> left >> top >> width >> height;
  std::istringstream path(between(svg, "class=\"line\" data-key=\"" + label + '"', " d=\"", "\""));
  for (char command = 0; path >> command >> left >> value;)
    most = std::max(most, std::abs(y["high"].get<double>() +
                                   (y["low"].get<double>() - y["high"].get<double>()) * (value - top) / height));
  return most;
}

}  // namespace viscobar
