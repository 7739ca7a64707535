#include <algorithm>
#include <utility>

#include "input/input_text.hpp"
#include "input/toml_text.hpp"

namespace viscobar {

namespace {

constexpr std::size_t most_parts = 32;  // of a dotted name; each part costs the parser a level of recursion

bool is_ascii(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

constexpr std::pair<std::string_view, std::string_view> letters[] = {
    {"\u201c", "\""}, {"\u201d", "\""}, {"\u201e", "\""}, {"\u2018", "'"},      {"\u2019", "'"},       {"\u2212", "-"},
    {"\u2013", "-"},  {"\u2014", "-"},  {"\u00a0", " "},  {"\u202f", " "},      {"\u2009", " "},       {"\u00b7", "*"},
    {"\u00d7", "*"},  {"\u22c5", "*"},  {"\u00f7", "/"},  {"\u00b2", "^2"},     {"\u00b3", "^3"},      {"\u03c0", "pi"},
    {"\u2264", "<="}, {"\u2265", ">="}, {"\u2260", "!="}, {"\u221a", "sqrt()"}, {"\u03b5", "epsilon"},
};

void check_encoding(std::string_view text) {
  const bool marked = text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF");
  const bool wide = text.size() >= 4 && ((text[0] == '\0') != (text[1] == '\0')) &&
                    (text[0] == '\0') == (text[2] == '\0') && (text[1] == '\0') == (text[3] == '\0');
  if (marked || wide) throw TextError({}, "this is UTF-16; save it as UTF-8");
  for (std::size_t i = text.find('\r'); i < text.size(); i = text.find('\r', i + 1))
    if (i + 1 < text.size() && text[i + 1] != '\n')
      throw TextError(position_in(text, i), "a carriage return alone ends no line; save the file with LF or CR LF");
}

class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {
    if (text_.starts_with("\xEF\xBB\xBF")) i_ = 3;
  }

  void scan() {
    bool statement_begins = true, in_value = false;
    std::string open;    // brackets of arrays and inline tables
    char before = '\n';  // the last character that is no blank
    std::size_t parts = 1;
    for (skip_blanks(); !at_end(); skip_blanks()) {
      const char c = text_[i_];
      if (c == '#' || (c == '[' && statement_begins)) {
        c == '#' ? skip_comment() : skip_header();
        continue;
      }
      if (!is_ascii({&c, 1})) fail_at_letter();
      const bool token_begins = before == '\n' || before == '=' || before == ',' || before == '[' || before == '{';
      if (is_quote(c)) {
        if (token_begins || (before == '.' && !in_value))
          skip_string(true);
        else
          skip_misplaced_string();
      } else if (in_value && token_begins && !is_one_of(c, "[]{},\n")) {
        skip_bare_value();
      } else {
        if (c == '.' && ++parts > most_parts) fail(i_, "this name has too many parts");
        if (c == '\n' || c == '=' || c == ',' || c == '[' || c == '{') parts = 1;
        if (c == '[' || c == '{') open += c;
        if ((c == ']' || c == '}') && !open.empty()) open.pop_back();
        const bool value_may_end = c == '\n' || c == ',' || c == '{';
        in_value = c == '=' || c == '[' || (value_may_end ? open.ends_with('[') : in_value);
        ++i_;
      }
      before = c;
      statement_begins = c == '\n' && open.empty();
    }
  }

 private:
  bool at_end() const { return i_ >= text_.size(); }
  char peek(std::size_t ahead = 0) const { return i_ + ahead < text_.size() ? text_[i_ + ahead] : '\0'; }
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
  static bool is_quote(char c) { return c == '"' || c == '\''; }
  static bool is_one_of(char c, std::string_view list) { return list.find(c) != list.npos; }
  static bool is_bare(char c) { return is_letter(c) || is_digit(c) || c == '_' || c == '-'; }
  [[noreturn]] void fail(std::size_t offset, const std::string& what) const {
    throw TextError(position_in(text_, offset), what);
  }

  [[noreturn]] void fail_at_letter() const {
    const std::string_view ascii = ascii_for(text_.substr(i_, character_length(text_, i_)));
    const std::string what = "letters beyond ASCII belong into quotes or comments only";
    fail(i_, ascii.empty()
                 ? what
                 : what + (ascii == " " ? "; this blank is none" : "; here it should be " + std::string(ascii)));
  }

  // To the parser all of it is one word, whatever it contains: brackets, quotes, equals signs.
  void skip_bare_value() {
    while (!at_end() && !is_blank(text_[i_]) && !is_one_of(text_[i_], "]},#\n")) {
      if (!is_ascii(text_.substr(i_, 1))) fail_at_letter();
      if (is_quote(text_[i_]))
        skip_misplaced_string();
      else
        ++i_;
    }
  }

  // The parser takes its quote for a letter of a bare word, and what follows for the rest of that.
  void skip_misplaced_string() {
    const std::size_t begin = i_;
    skip_string(true);
    if (!is_ascii(text_.substr(begin, i_ - begin)))
      fail(begin, "no string can begin here: what is before it does not belong to it");
  }

  void skip_blanks() {
    while (!at_end() && is_blank(text_[i_])) ++i_;
  }
  void skip_comment() { i_ = std::min(text_.find('\n', i_), text_.size()); }

  void skip_string(bool may_span_lines) {
    const std::size_t begin = i_;
    const char quote = text_[i_];
    const bool long_form = peek(1) == quote && peek(2) == quote;
    if (long_form && !may_span_lines) fail(begin, "a name cannot be a string of several lines");
    const std::string end(long_form ? 3 : 1, quote);
    i_ += end.size();
    while (!text_.substr(std::min(i_, text_.size())).starts_with(end)) {
      if (at_end() || (!long_form && text_[i_] == '\n')) fail(begin, "this string does not end");
      const bool escape = quote == '"' && text_[i_] == '\\';
      if (escape && long_form) check_continuation(i_ + 1);
      i_ += escape ? 2 : 1;
    }
    i_ += end.size();
    // Up to two quotes may precede the closing three.
    if (long_form)
      for (int k = 0; k < 2 && peek() == quote; ++k) ++i_;
  }

  // The parser asks of the letter behind a backslash, blanks and line ends in a string of several lines if it is a
  // blank: undefined for most letters beyond ASCII.
  void check_continuation(std::size_t i) const {
    while (i < text_.size() && (is_blank(text_[i]) || text_[i] == '\n')) ++i;
    if (i < text_.size() && !is_ascii(text_.substr(i, 1)))
      fail(i, "a letter beyond ASCII cannot be the first after a backslash");
  }

  void skip_header() {
    const std::size_t begin = i_;
    const std::size_t brackets = peek(1) == '[' ? 2 : 1;
    i_ += brackets;
    for (std::size_t parts = 1;; ++parts) {
      skip_blanks();
      const std::size_t name = i_;
      if (is_quote(peek())) {
        skip_string(false);
      } else {
        while (!at_end() && is_bare(text_[i_])) ++i_;
        if (i_ == name) fail(i_, "a table begins with its name in brackets, like [bar]");
      }
      if (parts > most_parts) fail(begin, "this name has too many parts");
      skip_blanks();
      if (peek() != '.') break;
      ++i_;
    }
    for (std::size_t k = 0; k < brackets; ++k, ++i_)
      if (peek() != ']') fail(i_, "a table begins with its name in brackets, like [bar]");
    skip_blanks();
    if (!at_end() && peek() != '\n' && peek() != '#') fail(i_, "nothing may follow a table's name on its line");
  }

  std::string_view text_;
  std::size_t i_ = 0;
};

}  // namespace

std::string_view ascii_for(std::string_view character) {
  for (const auto& [letter, ascii] : letters)
    if (letter == character) return ascii;
  return {};
}

void check_text(std::string_view text) {
  check_encoding(text);
  const std::size_t invalid = first_invalid_byte(text);
  if (invalid < text.size()) throw TextError(position_in(text, invalid), "this byte is not part of UTF-8 text");
  Scanner(text).scan();
}

}  // namespace viscobar
