// Prints every hard scene (docs/internals/stability.md) by every method that it is meant for, and the overrides. Run:
//     cmake --build --preset release --target measure_stability && build/release/tests/measure_stability ["" THREADS]
// With a part of a name, as in `measure_stability epsilon`, it runs those scenes and says more of each run.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "hard/hard_run.hpp"
#include "studies/parallel.hpp"

namespace {

using namespace viscobar;
using namespace viscobar::hard;

/// Messages by their number in the list below the table. The method stands in the table, and times, which differ
/// between methods and machines, are left out.
class Notes {
 public:
  std::size_t number(const std::string& told) {
    static const std::regex who(R"(^.*? (stopped )?at t = [^:]*: )"), number(R"(\d*\.\d+(e[-+]\d+)?)");
    const std::string message = std::regex_replace(std::regex_replace(told, who, ""), number, "...");
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

struct Run {
  HardScene scene;
  Mass row;  ///< in whose row it stands
  MethodName method;
  Mass mass;
  Outcome outcome = {};
  std::optional<std::string> complaint = {};
};

std::vector<Run> all_runs(const std::string& wanted) {
  std::vector<Run> runs;
  for (const HardScene& scene : catalogue()) {
    if (scene.name.find(wanted) == std::string::npos) continue;
    // The waves of the bar itself have no mass: they stand in the first row of their scene.
    const auto row_of = [&](MethodName method, Mass mass) {
      return method == MethodName::characteristics ? scene.masses.front() : mass;
    };
    for (const Mass row : all_masses)
      for (const MethodName method : methods_for(scene))
        for (const Mass mass : masses_for(scene, method))
          if (row_of(method, mass) == row) runs.push_back({scene, row, method, mass});
  }
  return runs;
}

void print_details(const Run& run) {
  static constexpr const char* kinds[] = {"right", "wrong", "stopped", "refused", "killed"};
  const Outcome& outcome = run.outcome;
  fmt::print("{} / {} / {}: {} {:.2g} ({}), {} steps, {} changes, {:.2f} s{}\n", run.scene.name, name(run.method),
             name(run.mass), kinds[static_cast<int>(outcome.kind)], outcome.ratio, outcome.message, outcome.steps,
             outcome.changes, outcome.cpu_seconds, run.complaint ? "  <-- not expected" : "");
}

void print_tables(const std::vector<Run>& runs) {
  fmt::print("| scene | file and overrides |\n|---|---|\n");
  for (const HardScene& scene : catalogue()) fmt::print("| {} | {} |\n", scene.name, command(scene));
  fmt::print("\n| scene | mass |");
  for (const MethodName method : all_methods) fmt::print(" {} |", name(method));
  fmt::print("\n|---|---|");
  for (std::size_t k = 0; k < std::size(all_methods); ++k) fmt::print("---|");
  fmt::print("\n");
  Notes notes;
  for (auto run = runs.begin(); run != runs.end();) {
    fmt::print("| {} | {} |", run->scene.name, name(run->row));
    const auto first = run;
    for (const MethodName method : all_methods) {
      const bool here =
          run != runs.end() && run->scene.name == first->scene.name && run->row == first->row && run->method == method;
      fmt::print(" {}|", here ? cell(run->outcome, run->complaint.has_value(), notes) + " " : "");
      if (here) ++run;
    }
    fmt::print("\n");
  }
  notes.print();
}

}  // namespace

int main(int count, char** words) {
  const std::string wanted = count > 1 ? words[1] : "";
  std::vector<Run> runs = all_runs(wanted);
  const auto judge = [&](std::size_t i) {
    Run& run = runs[i];
    run.outcome = run_guarded(run.scene, run.method, run.mass, run.scene.slow ? 3000 : patience);
    run.complaint = complaint(run.scene, run.method, run.outcome);
    if (run.complaint) fmt::print(stderr, "{}, {}: {}\n", run.scene.name, name(run.method), *run.complaint);
  };
  parallel_for(runs.size(), judge, count > 2 ? std::stoul(words[2]) : 0);
  if (wanted.empty())
    print_tables(runs);
  else
    std::ranges::for_each(runs, print_details);
  const auto wrong = std::ranges::count_if(runs, [](const Run& run) { return run.complaint.has_value(); });
  fmt::print("\n{} scenes, {} runs, {} of them not as expected.\n", catalogue().size(), runs.size(), wrong);
  return wrong > 0 ? 1 : 0;
}
