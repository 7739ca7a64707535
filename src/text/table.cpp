#include "text/table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "text/number.hpp"
#include "text/printable_text.hpp"

namespace viscobar {

std::string byte_number(double bytes) {
  if (bytes < 1e3) return fmt::format("{} B", bytes);
  if (bytes < 1e6) return fmt::format("{:.1f} kB", bytes / 1e3);
  return bytes < 1e9 ? fmt::format("{:.1f} MB", bytes / 1e6) : fmt::format("{:.1f} GB", bytes / 1e9);
}

std::string text(const Table& table) {
  std::vector<std::size_t> widths;
  for (const std::string& name : table.header) widths.push_back(name.size());
  for (const auto& row : table.rows)
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  std::string out;
  const auto add = [&](const std::vector<std::string>& row) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c)
      line += c < table.words ? fmt::format("  {:<{}}", row[c], widths[c]) : fmt::format("  {:>{}}", row[c], widths[c]);
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  };
  add(table.header);
  for (const auto& row : table.rows) add(row);
  return out;
}

std::string html(const Table& table) {
  const auto line = [&](const std::vector<std::string>& row, std::string_view tag) {
    std::string out = "<tr>";
    for (std::size_t c = 0; c < row.size(); ++c)
      out += fmt::format("<{0}{1}>{2}</{0}>", tag, c < table.words ? " class=\"word\"" : "",
                         escaped(with_readable_numbers(row[c])));
    return out + "</tr>";
  };
  constexpr std::size_t many = 7;
  std::string out = fmt::format("<div class=\"tables\"><table{}><thead>{}</thead><tbody>\n",
                                table.header.size() > many ? " class=\"wide\"" : "", line(table.header, "th"));
  for (const auto& row : table.rows) out += line(row, "td") + "\n";
  return out + "</tbody></table></div>\n";
}

std::string markdown(const Table& table) {
  std::string out = fmt::format("| {} |\n|", fmt::join(table.header, " | "));
  for (std::size_t c = 0; c < table.header.size(); ++c) out += c < table.words ? "---|" : "---:|";
  for (const auto& row : table.rows) out += fmt::format("\n| {} |", fmt::join(row, " | "));
  return out + "\n";
}

}  // namespace viscobar
