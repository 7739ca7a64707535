#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "viscobar/case/accuracy.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// One error of a scene file, at the value or key that causes it (line and column count from 1; for a missing key the
/// position of its table, or of the end of the file when the table is missing, too).
struct Diagnostic {
  std::string source;      ///< file name, or "--set" for an override
  std::size_t line = 1;    ///< from 1; 0 of what has no place in a text: a file that is not there, a value of a study
  std::size_t column = 1;  ///< from 1, in characters
  std::string key;         ///< "table.key"
  std::string message;     ///< the problem, with the nearest known key if one was probably meant

  std::string text() const;  ///< file:line:column: key: message, without a line key: message, or file: message
};

/// The user's scene cannot be run; has all its errors.
class SceneError : public std::runtime_error {
 public:
  explicit SceneError(std::vector<Diagnostic> found);  ///< a line of what() for each
  std::vector<Diagnostic> diagnostics;                 ///< in the order of the text, overrides last
};

/// A series of measured values, as an inline table says it: { file = "record.csv", column = "F" } or so.
using SceneTable = std::map<std::string, std::variant<double, std::string, std::vector<double>>>;

/// A value of a key: a text or formula, a whole number, a number, a list of words or of numbers, or a series.
using SceneValue =
    std::variant<std::string, std::int64_t, double, std::vector<std::string>, std::vector<double>, SceneTable>;

/// Keys "table.key" with their values, in the order in which a scene is told.
using SceneValues = std::vector<std::pair<std::string, SceneValue>>;

/// Something laid over a scene: a key with its value, or the text "table.key=value" of --set; "table.key=" takes the
/// key away.
using Setting = std::variant<std::string, std::pair<std::string, SceneValue>>;

/// A case as read, and the scene as understood.
struct SceneFile {
  Case run;            ///< sound
  SceneValues values;  ///< of every key, defaults included
  SceneValues chosen;  ///< of keys that the scene leaves out: those that the program chose

  std::optional<AccuracyRequest> accuracy;  ///< where the scene asks for an error

  /// `values` as one JSON object; it reads back to the same.
  std::string description() const;
};

/// A change that a study makes to a case before it is validated, such as another method.
using Adaptation = std::function<void(Case&)>;

/// Reads a scene (TOML, see docs/scene-file.md), applies overrides "table.key=value" in order, validates.
/// @throws SceneError with all errors of the file
SceneFile read_scene(const std::filesystem::path& file, std::span<const std::string> overrides = {},
                     const Adaptation& adapt = {});

/// The same from text; `source` names it in diagnostics.
SceneFile parse_scene(const std::string& text, const std::string& source, std::span<const std::string> overrides = {},
                      const Adaptation& adapt = {});

}  // namespace viscobar
