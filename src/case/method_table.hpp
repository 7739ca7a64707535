#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <span>
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

  std::vector<Finding> take() { return std::move(found_); }

 private:
  std::vector<std::string> wrong_;
  std::vector<Finding> found_;
};

/// What makes a method's error small: tolerances, a fixed time step with the constraint solved in each, or nothing, for
/// it is exact in time.
enum class Accuracy { tolerances, step, rounding };

/// What a step costs: step + node * (number of nodes) seconds.
struct StepSeconds {
  double step, node;
};

/// All that is said about one method. Scene files, validation, runs, studies and estimates go by this table. A pointer
/// that is null stands for "as every other method".
struct MethodRow {
  MethodName method;
  std::string_view name, meaning;  ///< in a scene file
  bool penalised;
  Accuracy accuracy;
  StepSeconds seconds;
  Method (*options)(const Case&);
  double (*vectors)(const Case&, double nodes) = nullptr;  ///< own memory, in vectors with an entry a node
  Mass (*mass)(const Case&) = nullptr;                     ///< that it runs on, where not the case's
  bool differentiates = false;                             ///< tells sensitivities
  bool takes_algebraic_rows = true;                        ///< massless contact nodes without viscosity
  /// Adds what else the method, known to be meant, cannot take.
  void (*refuse)(const Case&, Findings&) = nullptr;

  /// Whether that of massless contact nodes, whose rows are algebraic without viscosity.
  bool takes_massless(const Case& on) const { return takes_algebraic_rows || on.scene.bar.viscosity > 0.0; }
};

/// Whether the case has massless contact nodes without viscosity, whose equations are algebraic.
bool has_algebraic_rows(const Case& run);

/// In the order of all_methods.
std::span<const MethodRow> method_table();

const MethodRow& method_row(MethodName method);

}  // namespace viscobar
