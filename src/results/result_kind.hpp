#pragma once

#include <span>
#include <string_view>

namespace viscobar {

/// The commands that leave results; each has files of its own.
enum class ResultKind { run, compare, limit, precision, sweep, fit, judge };

/// Files of a kind, as lists of words with spaces between.
struct ResultFiles {
  std::string_view kind;
  std::string_view first;    ///< the file that is written before the others: the summary, of a sweep its table
  std::string_view summary;  ///< as JSON
  std::string_view others;
  /// The first file is ours where it holds all of these; of a table, which finds itself what is damaged in it, one is
  /// enough.
  std::string_view marks;
  /// Facts that are worth knowing: NAME, which with spaces is its name on the terminal, of a member of the summary, or
  /// NAME=PATH.
  std::string_view facts;

  bool table() const { return first != summary; }
};

/// In the order of ResultKind.
std::span<const ResultFiles> result_kinds();
inline const ResultFiles& files_of(ResultKind kind) { return result_kinds()[static_cast<std::size_t>(kind)]; }

}  // namespace viscobar
