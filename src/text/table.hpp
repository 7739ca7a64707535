#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace viscobar {

/// A table of words and numbers, the same for the terminal and for a page.
struct Table {
  std::vector<std::string> header;
  std::size_t words = 1;  ///< columns from the left that hold words, set flush left; the others hold numbers
  std::vector<std::vector<std::string>> rows;
};

std::string byte_number(double bytes);  ///< with the unit that suits it: 512 B, 75.2 kB, 1.3 GB

std::string text(const Table& table);
std::string html(const Table& table);
std::string markdown(const Table& table);

}  // namespace viscobar
