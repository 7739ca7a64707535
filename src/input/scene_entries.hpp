#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "input/formula.hpp"
#include "input/scene_keys.hpp"
#include "input/series.hpp"
#include "input/toml_text.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {

/// Message on "table.leaf", which is no key of a scene: with the nearest key, or those of the table.
std::string unknown_key(std::string_view table, std::string_view leaf);

/// The keys of a scene with their values, as far as each is right by itself, where each one stands, and all that was
/// found wrong so far. A key that something was found wrong with is faulty: it has no value any more, and whoever
/// needs one goes on with a harmless one, so that what else is wrong comes to light in the same run.
class SceneEntries {
 public:
  /// Reads the text, lays the settings over it, checks every value against scene_keys(), fills in fallbacks.
  SceneEntries(const std::string& text, const std::string& source, std::span<const Setting> settings);
  SceneEntries(SceneEntries&&) = default;
  SceneEntries& operator=(SceneEntries&&) = default;

  /// False when the text is not TOML: what it holds is unknown then.
  bool readable() const { return readable_; }
  bool has_table(std::string_view table) const { return tables_.contains(table); }
  /// How many tables [[bar]] of several, or [[joint]], there are; 0 for one bar.
  std::size_t members(std::string_view table) const;
  /// Reports tables of members whose numbers go on behind a gap, as a key that is set may.
  void report_members_apart();
  bool present(std::string_view key) const { return find(key) != nullptr; }
  bool given(std::string_view key) const { return entries_.contains(key); }
  /// True if any key is that begins so.
  bool given_below(std::string_view prefix) const {
    const auto next = entries_.lower_bound(prefix);
    return next != entries_.end() && next->first.starts_with(prefix);
  }
  bool faulty(std::string_view key) const { return faulty_.contains(key); }
  bool sound(std::string_view key) const { return present(key) && !faulty(key); }
  std::vector<std::string> faulty_keys() const { return {faulty_.begin(), faulty_.end()}; }

  // Values of keys that are present and not faulty.
  std::optional<double> number(std::string_view key) const;
  std::optional<std::string> text(std::string_view key) const;
  std::optional<Formula> formula(std::string_view key) const;
  std::vector<std::string> list(std::string_view key) const;  ///< empty where the key is absent
  std::vector<double> numbers(std::string_view key) const;    ///< empty where the key is absent
  /// The series that is the value of a key; null where the value is none.
  std::shared_ptr<const Series> series(std::string_view key) const;
  std::vector<std::string> series_keys() const;  ///< whose values are series
  Units units() const;                           ///< those that the scene names
  /// The value of a key that is there and sound as results describe it: the file of a series by its whole name and with
  /// a checksum.
  SceneValue described(std::string_view key) const;
  Parameters parameters() const;

  /// As the user or the fallback put it.
  const TomlValue& value(std::string_view key) const { return *find(key); }

  /// Notes what is wrong with a key, at its value, or else at its table, or else at the end of the text.
  void report(std::string_view key, const std::string& message);
  template <class... Args>
  void report(std::string_view key, fmt::format_string<Args...> message, Args&&... args) {
    report(key, fmt::format(message, std::forward<Args>(args)...));
  }

  /// All that was found, in the order of the text, overrides last.
  std::vector<Diagnostic> diagnostics() const;

 private:
  struct Place {
    std::string source;
    TextPosition at;
  };
  struct Entry {
    TomlValue value;
    Place place;
  };

  SceneEntries(const std::string& text, const std::string& source);
  // Only of entries whose values are not in force yet: those point into them.
  SceneEntries(const SceneEntries&) = default;
  static std::shared_ptr<const SceneEntries> of_text(const std::string& text, const std::string& source);
  void add_text(const std::string& text);
  void add_override(const std::string& text);
  void lay_over(const std::string& name, TomlValue value, TextPosition key_at, TextPosition value_at);
  /// Adds an entry of a table; `written` is the name of the table in the text.
  void add(const TomlNode& entry, const std::string& written, std::string_view table, const std::string& source);
  void unset(std::string_view name);
  void drop_what_no_longer_belongs();
  void check_values();
  void read_series(const std::string& name, const SceneTable& table);
  void fill_in();
  const TomlValue* find(std::string_view key) const;  // null: absent
  const TomlValue* sound_value(std::string_view key) const;
  Place place_of(std::string_view key) const;
  std::filesystem::path folder() const { return std::filesystem::path(end_.source).parent_path(); }
  void report_at(const Place& place, const std::string& key, const std::string& message);

  Place end_;
  bool readable_ = true;
  std::map<std::string, Entry, std::less<>> entries_;
  std::map<std::string, Place, std::less<>> tables_;
  std::set<std::string, std::less<>> faulty_;
  std::map<std::string, std::shared_ptr<const Series>, std::less<>> series_;
  std::vector<const TomlValue*> in_force_;  // of scene_keys(), in their order: given, fallback or null; empty before
  std::vector<Diagnostic> found_;
};

/// Motion scale f(t) + offset of an end, or its derivative with respect to a parameter.
EndMotion motion_of(const Formula& f, const std::string& by, double scale, double offset);
/// Motion of an obstacle with gap(t), or its derivative; `obstacle` has the gap at the start.
EndMotion motion_of_gap(const Formula& gap, const std::string& by, const Obstacle& obstacle);

/// The direction of a key of a scene file, or of parameters.NAME: formulas are differentiated, not differenced. `run`
/// is the case of the entries but for its method, where that is chosen for it.
/// @throws std::invalid_argument where there is none
Direction direction_of(const SceneEntries& entries, const Case& run, const std::string& key);

/// The density of a load, or the profile and history that it is a product of, as given or as the density's formula is.
struct LoadFormulas {
  explicit LoadFormulas(const SceneEntries& entries);
  std::optional<Formula> density, profile, history;
};

}  // namespace viscobar
