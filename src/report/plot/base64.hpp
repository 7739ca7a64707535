#pragma once

#include <string>
#include <string_view>

namespace viscobar::plot {

/// Base64 of RFC 4648, padded, in one line.
std::string base64(std::string_view bytes);

}  // namespace viscobar::plot
