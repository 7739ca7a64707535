#pragma once

#include <span>
#include <string>

#include "report/number_text.hpp"
#include "text/table.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

/// A row for each of the first `most` cases: the varied keys, and of the columns that differ from case to case the most
/// telling ones.
Table sweep_text_table(const SweepFile& sweep, std::span<const SweepRow* const> rows, std::size_t most,
                       NumberText::For reader);

/// sweep.html: any column over one or two keys, as lines or as a map, with filters, and the run behind each point. It
/// needs no other file. Of more than `most_on_page` cases it holds the first.
inline constexpr std::size_t most_on_page = 10'000;
std::string sweep_page(const SweepFile& sweep, std::span<const SweepRow* const> rows);

}  // namespace viscobar
