#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// A page of HTML that needs no other file and no network, light or dark as the reader's system is: the title, the
/// equation of the scene, `head` below it (HTML, may be empty), `body` (HTML) and a footer with the versions.
std::string page_html(std::string_view title, const Scene& scene, std::string_view head, std::string_view body);

/// The scene's equation and ends in a sentence.
std::string model_html(const Scene& scene);

std::string section_html(std::string_view heading, std::string_view content);

/// A picture with its heading above and its caption below (all HTML).
std::string figure_html(std::string_view picture, std::string_view heading, std::string_view caption);

/// Named values in columns.
class Numbers {
 public:
  void add(std::string_view name, const std::string& value, std::string_view remark = {});
  void add(std::string_view name, std::size_t value);
  std::string html(std::string_view heading) const;

 private:
  std::string html_;
};

}  // namespace viscobar
