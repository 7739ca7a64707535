#pragma once

#include <string_view>

/// The files that pages are made of, embedded by cmake/embed.cmake.
namespace viscobar::page_files {

extern const std::string_view style;          ///< src/report/web/*.css
extern const std::string_view script;         ///< src/report/web/*.js
extern const std::string_view chart_style;    ///< third_party/uplot
extern const std::string_view chart_script;   ///< third_party/uplot
extern const std::string_view chart_licence;  ///< third_party/uplot

}  // namespace viscobar::page_files
