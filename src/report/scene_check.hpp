#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "case/regime.hpp"
#include "case/run_cost.hpp"
#include "report/number_text.hpp"
#include "report/scene_ends.hpp"
#include "results/csv.hpp"
#include "viscobar/case/accuracy.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {

struct SceneCheck {
  SceneFile scene;                     ///< with the settings that [accuracy] leads to
  Setup setup;                         ///< of its case
  BarSystem system;                    ///< with the terms that the scene has
  std::optional<Foresight> foreseen;   ///< absent where the scene is large
  std::vector<ContactRegime> regimes;  ///< of the contacts of a penalised method
  MemoryNeed memory;                   ///< of the run
  std::optional<ErrorEstimate> error;  ///< that the run will tell; absent for large scenes
  std::size_t error_elements = 0;      ///< of the mesh that it is of: fewer where the scene's takes long
  std::string no_error;                ///< why it is absent, in half a sentence
  std::vector<std::string> warnings;   ///< with remedies, a sentence each
};

/// `stop` ends runs that are made for the check; may be empty. @throws std::invalid_argument for data that no run takes
SceneCheck check_scene(const SceneFile& scene, const std::function<bool()>& stop = {});

std::string check_json(const SceneCheck& check);

std::string_view name(ImpactPrediction::Layer layer);
std::string_view load_kind(const Scene& scene);
/// The resistance along the bar, with the frequency and the decay that it gives to a bar that moves as a whole.
std::string side_text(const Scene& scene);
std::string section_text(const Scene& scene, NumberText::For reader = NumberText::For::terminal);
/// A line for each member of a chain: what it is, and how it hangs together with the next.
std::vector<std::string> member_texts(const Scene& scene, NumberText::For reader = NumberText::For::terminal);
/// Forces, motion and supports of an end, and their terms in the model, a sentence for each.
std::vector<std::string> inputs_text(const Scene& scene, const Bar& bar, const SceneEnd& end);
std::string contact_kind(const Setup& setup);

}  // namespace viscobar
