#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "viscobar/case/case.hpp"

namespace viscobar {

/// What is wrong with a case so far. A key with a finding has no value to judge others by.
class Findings {
 public:
  /// `faulty` are keys known to be wrong already, of which nothing more is said.
  explicit Findings(const std::vector<std::string>& faulty) : wrong_(faulty) {}

  /// Several findings of one check may have the same key.
  void add(std::vector<Finding> found) {
    std::erase_if(found, [&](const Finding& one) { return !sound({one.key}); });
    for (Finding& one : found) {
      wrong_.push_back(one.key);
      found_.push_back(std::move(one));
    }
  }
  void report(std::string_view key, std::string problem) { add({{std::string(key), std::move(problem)}}); }
  template <class... Args>
  void report(std::string_view key, fmt::format_string<Args...> problem, Args&&... args) {
    if (sound({key})) report(key, fmt::format(problem, std::forward<Args>(args)...));
  }

  bool sound(std::initializer_list<std::string_view> keys) const {
    return std::none_of(keys.begin(), keys.end(), [&](std::string_view key) {
      return std::find(wrong_.begin(), wrong_.end(), key) != wrong_.end();
    });
  }
  /// Of all keys of tables, those of `initial` such as `initial.velocity`.
  bool sound_tables(std::initializer_list<std::string_view> tables) const {
    return std::none_of(wrong_.begin(), wrong_.end(), [&](std::string_view key) {
      return std::find(tables.begin(), tables.end(), key.substr(0, key.find('.'))) != tables.end();
    });
  }

  std::vector<Finding> take() { return std::move(found_); }

 private:
  std::vector<std::string> wrong_;
  std::vector<Finding> found_;
};

}  // namespace viscobar
