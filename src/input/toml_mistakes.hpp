#pragma once

#include <string_view>

namespace viscobar {

/// What somebody meant who wrote this line, which is not TOML, and what to write instead: habits from other languages
/// and formats, such as a decimal comma, // before a comment, a formula without quotes. Empty when it is none of them.
std::string_view toml_advice(std::string_view line);

}  // namespace viscobar
