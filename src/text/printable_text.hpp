#pragma once

#include <string>
#include <string_view>

namespace viscobar {

/// A text as a terminal, a log or a page can show it: what would steer them stands as its number, as TOML and JSON
/// write it. These are control characters (\u001b begins the escape sequences of terminals, \u009b too), what reverses
/// the direction of writing (\u202e), and bytes that are not UTF-8 (\x9b). New lines and tabs stay.
std::string printable(std::string_view text);

/// The same on one line: new lines and tabs, too, as numbers.
std::string one_line(std::string_view text);

/// Printable text made safe for HTML and SVG.
std::string escaped(std::string_view text);

}  // namespace viscobar
