// Prints the tables of docs/stability.md: every hard scene by every method that it is meant for. Run:
//     cmake --build --preset release --target measure_stability && build/release/tests/measure_stability
// With a part of a name, as in `measure_stability epsilon`, it runs those scenes and says more of each run.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "hard/hard_run.hpp"

namespace {

using namespace viscobar;
using namespace viscobar::hard;

/// Messages by their number in the list below the table.
class Notes {
 public:
  std::size_t number(const std::string& message) {
    const auto known = std::ranges::find(messages_, message);
    if (known != messages_.end()) return static_cast<std::size_t>(known - messages_.begin()) + 1;
    messages_.push_back(message);
    return messages_.size();
  }
  void print() const {
    fmt::print("\n");
    for (std::size_t i = 0; i < messages_.size(); ++i) fmt::print("{}. {}\n", i + 1, messages_[i]);
  }

 private:
  std::vector<std::string> messages_;
};

std::string cell(const Outcome& outcome, bool complained, Notes& notes) {
  std::string text;
  switch (outcome.kind) {
    case Outcome::Kind::right:
    case Outcome::Kind::wrong: text = fmt::format("{:.1g}, {}", outcome.ratio, outcome.steps); break;
    case Outcome::Kind::error: text = fmt::format("stopped ({})", notes.number(outcome.message)); break;
    case Outcome::Kind::refused: text = fmt::format("refused ({})", notes.number(outcome.message)); break;
    case Outcome::Kind::killed: text = fmt::format("killed ({})", notes.number(outcome.message)); break;
  }
  return complained ? fmt::format("**{}**", text) : text;
}

std::string command(const HardScene& scene) {
  return fmt::format("`{}{}{}`", scene.file, scene.overrides.empty() ? "" : " ", fmt::join(scene.overrides, " "));
}

void print_details(const HardScene& scene, MethodName method, Mass mass, const Outcome& outcome) {
  static constexpr const char* kinds[] = {"right", "WRONG", "stopped", "refused", "killed"};
  fmt::print("{} / {} / {}: {} {:.2g} ({}), {} steps, {} changes, {:.2f} s{}\n", scene.name, name(method), name(mass),
             kinds[static_cast<int>(outcome.kind)], outcome.ratio, outcome.message, outcome.steps, outcome.changes,
             outcome.cpu_seconds, complaint(scene, method, outcome) ? "  <-- NOT EXPECTED" : "");
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** words) {
  const std::string wanted = count > 1 ? words[1] : "";
  Notes notes;
  std::size_t runs = 0, wrong = 0;
  std::vector<std::string> rows;
  for (const HardScene& scene : catalogue()) {
    if (scene.name.find(wanted) == std::string::npos) continue;
    const std::vector<MethodName> methods = methods_for(scene);
    for (const Mass mass : scene.masses) {
      std::string row = fmt::format("| {} | {} |", scene.name, name(mass));
      for (const MethodName method : all_methods) {
        const std::vector<Mass> masses = masses_for(scene, method);
        const bool meant = std::ranges::count(methods, method) > 0;
        // Rigid has one mass: it stands in the last row of its scene.
        if (!meant || (method == MethodName::rigid && mass != scene.masses.back())) {
          row += " |";
          continue;
        }
        const Mass taken = method == MethodName::rigid ? masses.front() : mass;
        const Outcome outcome = run_guarded(scene, method, taken, scene.slow ? 3000 : 100);
        const bool complained = complaint(scene, method, outcome).has_value();
        ++runs;
        wrong += complained;
        row += fmt::format(" {} |", cell(outcome, complained, notes));
        if (complained || outcome.cpu_seconds > 10.0)  // for who waits
          fmt::print(stderr, "{} / {} / {}: {}, {:.0f} s\n", scene.name, name(method), name(taken), outcome.message,
                     outcome.cpu_seconds);
        if (!wanted.empty()) print_details(scene, method, taken, outcome);
      }
      rows.push_back(row);
    }
  }
  if (wanted.empty()) {
    fmt::print("| scene | file and overrides |\n|---|---|\n");
    for (const HardScene& scene : catalogue()) fmt::print("| {} | {} |\n", scene.name, command(scene));
    fmt::print("\n| scene | mass |");
    for (const MethodName method : all_methods) fmt::print(" {} |", name(method));
    fmt::print("\n|---|---|---|---|---|---|---|---|---|---|\n");
    for (const std::string& row : rows) fmt::print("{}\n", row);
    notes.print();
  }
  fmt::print("\n{} scenes, {} runs, {} of them wrong.\n", catalogue().size(), runs, wrong);
  return wrong > 0 ? 1 : 0;
}
