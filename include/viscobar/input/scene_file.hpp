#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "viscobar/case/accuracy.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// One error of a scene file, at the value or key that causes it (line and column count from 1; for a missing key the
/// position of its table, or of the end of the file when the table is missing, too).
struct Diagnostic {
  std::string source;      ///< file name, or "--set" for an override
  std::size_t line = 1;    ///< from 1
  std::size_t column = 1;  ///< from 1, in characters
  std::string key;         ///< "table.key"
  std::string message;     ///< the problem, with the nearest known key if one was probably meant

  std::string text() const;  ///< file:line:column: key: message
};

/// The user's scene cannot be run; has all its errors.
class SceneError : public std::runtime_error {
 public:
  explicit SceneError(std::vector<Diagnostic> found);  ///< what() has a line for each
  std::vector<Diagnostic> diagnostics;                 ///< in the order of the text, overrides last
};

/// A case as read, and the scene as understood: every key with its value, defaults included, as one JSON object.
struct SceneFile {
  Case run;                   ///< sound
  std::string description;    ///< the JSON object
  std::string chosen = "{}";  ///< another one: keys that the scene leaves out, with the values that the program chose

  std::optional<AccuracyRequest> accuracy;  ///< where the scene asks for an error

  /// Both together: what was run.
  std::string complete() const;
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
