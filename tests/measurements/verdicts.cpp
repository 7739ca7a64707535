// Prints the table of docs/limit-verdicts.md: verdicts of `limit` beside what is known by other means. Run:
// build/release/tests/measure_verdicts
// build/release/tests/measure_verdicts --seed 2026        (60 random scenes of another seed)
// build/release/tests/measure_verdicts --orders 7         (powers of epsilon of 100 random scenes beside theory's)
// build/release/tests/measure_verdicts paper              (the rows of part of a scene's name alone)
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "support/verdict_scenes.hpp"
#include "support/verdict_truth.hpp"
#include "viscobar/input/scene_file.hpp"

namespace {

using namespace viscobar;

std::vector<VerdictScene> shipped_scenes() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(VISCOBAR_SOURCE_DIR "/examples/scenes"))
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<VerdictScene> scenes;
  for (const auto& file : files) {
    Case run = read_scene(file, {}, [](Case& one) {
                 one.epsilon = 1e-4 * natural_epsilon(one.scene);
                 one.method = penalised_method(one);
                 one.mass = common_mass(one);
               }).run;
    // Theory speaks of bars alone.
    if (!limit_fault(run.scene) && run.scene.chain.empty())
      scenes.push_back({file.stem().string(), "", std::move(run)});
  }
  return scenes;
}

std::string ends(const Scene& scene) {
  const auto one = [](const EndCondition& end) {
    return is_obstacle(end) ? "obstacle" : is_fixed(end) ? "fixed" : "free";
  };
  return scene.span ? std::string("span") : fmt::format("{}, {}", one(scene.left), one(scene.right));
}

std::string load(const VerdictScene& scene) {
  if (!scene.load.empty()) return scene.load;
  return scene.run.scene.load ? "yes" : "none";
}

std::string number(std::optional<double> value) { return value ? fmt::format("{:.1e}", *value) : "-"; }

// Scenes with one limit: theory has the power 1 on massless contact nodes, 1/2 on nodes with mass and one restitution.
void print_orders(unsigned seed) {
  constexpr std::size_t all = 100;
  std::size_t count = 0, told = 0, off = 0;
  fmt::print(
      "| scene | elements | mass, restitution | viscosity | load | theory | to its own limit | to the scheme |\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  for (const VerdictScene& scene : random_verdict_scenes(2 * all, seed)) {
    const bool massless = scene.run.mass == Mass::redistributed;
    if (scene.pressed || (!massless && !scene.run.restitution) || count == all) continue;
    const LimitResult result = limit_of(verdict_study(scene));
    const LimitOrders& orders = result.orders.front();
    if (orders.evidence.missing == Missing::contact) continue;
    ++count;
    const double theory = massless ? 1.0 : 0.5;
    bool is_off = false;
    const auto text = [&](const std::optional<SequenceOrder>& order) {
      if (!order) return std::string("-");
      is_off |= std::abs(order->order - theory) > 0.03;
      return fmt::format("{:.3f} +- {:.3f} by {}", order->order, order->bound, order->last - order->first + 1);
    };
    const std::string own = text(orders.to_own_limit), scheme = text(orders.to_scheme);
    told += orders.to_own_limit.has_value();
    off += is_off;
    fmt::print("| {} | {} | {}, {} | {:.2g} | {} | {} | {} | {}{} |\n", scene.name, scene.run.elements,
               name(resolve(scene.run).mass),
               scene.run.restitution ? fmt::format("e = {}", *scene.run.restitution) : "none",
               scene.run.scene.bar.viscosity, scene.load, theory, own, scheme, is_off ? " (OFF)" : "");
  }
  fmt::print("\n{} scenes: a power is told in {}, off by more than 0.03 in {}.\n", count, told, off);
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (argc > 2 && std::string(argv[1]) == "--orders") {
    print_orders(static_cast<unsigned>(std::stoul(argv[2])));
    return 0;
  }
  constexpr std::size_t all = 60;
  const bool seeded = argc > 2 && std::string(argv[1]) == "--seed";
  std::vector<VerdictScene> scenes = seeded ? std::vector<VerdictScene>() : shipped_scenes();
  const unsigned seed = seeded ? static_cast<unsigned>(std::stoul(argv[2])) : 1523;
  for (VerdictScene& scene : random_verdict_scenes(all - scenes.size(), seed)) scenes.push_back(std::move(scene));
  fmt::print(
      "| scene | elements | mass, restitution | viscosity | ends | load | truth by theory | distance by other runs | "
      "verdict | apart, at least | at most | smallest step | seconds |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  std::size_t undecided = 0, wrong = 0, untouched = 0, outside = 0;
  for (const VerdictScene& scene : scenes) {
    if (argc > 1 && !seeded && scene.name.find(argv[1]) == std::string::npos) continue;
    const LimitResult result = limit_of(verdict_study(scene));
    const LimitOrders& orders = result.orders.front();
    const LimitEvidence& evidence = orders.evidence;
    const KnownVerdict known = known_verdict(scene);
    const bool same = orders.verdict == known.verdict, open = orders.verdict == Verdict::undecided;
    undecided += open;
    untouched += !known.touches;
    wrong += !open && !same;
    const bool inside = agrees(evidence, known);
    outside += !inside;
    double seconds = 0.0;
    for (const SchemeRun& run : orders.scheme) seconds += run.seconds;
    fmt::print(
        "| {} | {} | {}, {} | {:.2g} | {} | {} | {} | {} | {}{} | {} | {} | {:.1e} | {:.1f} |\n", scene.name,
        scene.run.elements, name(resolve(scene.run).mass),
        scene.run.restitution ? fmt::format("e = {}", *scene.run.restitution) : "none", scene.run.scene.bar.viscosity,
        ends(scene.run.scene), load(scene), known.touches ? std::string(name(known.verdict)) : "nothing touches",
        known.distance ? fmt::format("{:.1e} +- {:.0e}", *known.distance, known.error) : "-", name(orders.verdict),
        !open && !same ? " (WRONG)"
        : inside       ? ""
                       : " (OUTSIDE)",
        number(evidence.lower()),
        evidence.until ? fmt::format("up to t = {:.2g}", *evidence.until) : number(evidence.upper()),
        orders.scheme_step, seconds);
  }
  fmt::print(
      "\n{} scenes: {} verdicts are wrong, {} are undecided, {} of which because nothing touches. In {} the distance "
      "by other runs is outside the bounds.\n",
      scenes.size(), wrong, undecided, untouched, outside);
}
