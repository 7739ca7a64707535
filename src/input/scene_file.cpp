#include "viscobar/input/scene_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "case/method_table.hpp"
#include "input/described_scene.hpp"
#include "input/input_text.hpp"
#include "input/scene_chain.hpp"
#include "input/scene_entries.hpp"
#include "input/scene_stop.hpp"
#include "input/scene_values.hpp"
#include "scene/end_kinds.hpp"
#include "scene/message_text.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

constexpr Stepper all_steppers[] = {Stepper::automatic, Stepper::rosenbrock4, Stepper::dopri5};

template <class All, class One>
One chosen(const SceneEntries& entries, const std::string& key, const All& all, One otherwise) {
  const auto word = entries.text(key);
  for (const One one : all)
    if (word == name(one)) return one;
  return otherwise;
}

Side side_of(const SceneEntries& entries, const std::string& table) {
  return chosen(entries, table + ".side", all_sides, Side::below);
}

EndCondition end_of(const SceneEntries& entries, const std::string& side) {
  const auto word = entries.text(side + ".kind");
  for (const EndKind& kind : end_kinds) {
    if (word != kind.name) continue;
    EndCondition end = kind.harmless;
    for (const EndNumber& number : kind.numbers)
      if (const auto value = entries.formula(fmt::format("{}.{}", side, number.key)))
        number.of(end) = value->is_constant() ? value->constant() : value->of_t()(0.0);
    if (auto* obstacle = std::get_if<Obstacle>(&end)) obstacle->side = side_of(entries, side);
    return end;
  }
  return Free{};
}

EndInput input_of(const SceneEntries& entries, const std::string& side, const EndCondition& end) {
  EndInput input;
  const auto number = [&](const char* key) { return entries.number(side + key).value_or(0.0); };
  input.stiffness = number(".stiffness");
  input.dashpot = number(".dashpot");
  input.mass = number(".mass");
  if (const auto force = entries.formula(side + ".force"); force && !force->is_zero())
    input.force = EndForce{force->of_t(), force->breaks_and_pulses(0.0), force->is_constant()};
  if (const auto motion = entries.formula(side + ".motion"); motion && !motion->is_zero())
    input.motion = motion_of(*motion, "", 1.0, 0.0);
  if (is_obstacle(end)) input.stop = stop_of(entries, side);
  if (const auto* obstacle = std::get_if<Obstacle>(&end))
    if (const auto gap = entries.formula(side + ".gap"); gap && !gap->is_constant())
      input.motion = motion_of_gap(*gap, "", *obstacle);
  return input;
}

// The narrowest kind of load that the formulas allow, and none at all for one that is zero.
std::optional<Load> load_of(const SceneEntries& entries, double length) {
  const auto [density, profile, history] = LoadFormulas(entries);
  if (density) {
    if (density->is_zero()) return std::nullopt;
    if (!density->uses('t')) return SteadyLoad{density->of_x(), density->places(length)};
    if (!density->uses('x'))
      return SeparableLoad{[](double) { return 1.0; }, density->of_t(), density->breaks_and_pulses(0.0)};
    return GeneralLoad{density->of_x_t(),         density->breaks_and_pulses(length), density->breaks_at(),
                       density->breaks_in_x_at(), density->detail_in_x_at(length),    density->breaks()};
  }
  if (!profile || !history || profile->is_zero() || history->is_zero()) return std::nullopt;
  if (history->is_constant())
    return SteadyLoad{[f = profile->of_x(), factor = history->constant()](double x) { return factor * f(x); },
                      profile->places(length)};
  return SeparableLoad{profile->of_x(), history->of_t(), history->breaks_and_pulses(0.0), profile->places(length)};
}

// Nothing of a resistance that is zero.
std::optional<SideResistance> resistance_of(const SceneEntries& entries, double length) {
  SideResistance side;
  const auto take = [&](const char* key, SpaceFunction& function, Places& places) {
    if (const auto formula = entries.formula(key); formula && !formula->is_zero())
      function = formula->of_x(), places = formula->places(length);
  };
  take("side.stiffness", side.stiffness, side.stiffness_places);
  take("side.drag", side.drag, side.drag_places);
  if (!side.stiffness && !side.drag) return std::nullopt;
  return side;
}

OutputFiles files_of(const SceneEntries& entries) {
  if (!entries.sound("output.write")) return {};
  const auto words = entries.list("output.write");
  const auto named = [&](std::string_view file) { return std::ranges::find(words, file) != words.end(); };
  return {named("ends"), named("events"), named("field"), named("energy"), named("report")};
}

// The case that the sound keys make; a faulty one gets a value that does no harm.
Case case_of(SceneEntries& entries) {
  const auto number = [&](const char* key, double otherwise) { return entries.number(key).value_or(otherwise); };
  const auto function = [&](const char* key) {
    return entries.faulty("bar.length") ? Formula(0.0).of_x() : entries.formula(key).value_or(Formula(0.0)).of_x();
  };

  Case run;
  const auto text = [&](const char* key) { return entries.text(key).value_or(""); };
  run.scene.title = text("title");
  run.scene.bar = {number("bar.length", 1.0), number("bar.density", 1.0), number("bar.modulus", 1.0),
                   number("bar.viscosity", 1.0)};
  Scene& scene = run.scene;
  scene.left = end_of(entries, "left");
  scene.right = end_of(entries, "right");
  scene.left_input = input_of(entries, "left", scene.left);
  scene.right_input = input_of(entries, "right", scene.right);
  if (entries.present("span.gap")) scene.span = Obstacle{number("span.gap", 1e100), side_of(entries, "span")};
  scene.displacement = function("initial.displacement");
  scene.velocity = function("initial.velocity");
  const auto places = [&](const char* key) {
    return entries.formula(key).value_or(Formula(0.0)).places(run.scene.bar.length);
  };
  scene.displacement_places = places("initial.displacement");
  scene.velocity_places = places("initial.velocity");
  scene.load = load_of(entries, run.scene.bar.length);
  if (const auto section = entries.formula("bar.section"); section && !entries.faulty("bar.length"))
    scene.section = section->of_x(), scene.section_places = places("bar.section");
  scene.side = resistance_of(entries, scene.bar.length);
  scene.units = entries.units();

  run.elements =
      entries.faulty("mesh.elements") ? 1 : static_cast<std::size_t>(number("mesh.elements", default_elements));
  run.grading = number("mesh.grading", 1.0);
  run.nodes = nodes_of(entries, "mesh.nodes", run.scene.bar.length);
  if (run.nodes && !entries.present("mesh.elements")) run.elements = run.nodes->size() - 1;
  take_chain(entries, run);
  if (entries.present("mesh.mass")) run.mass = chosen(entries, "mesh.mass", all_masses, Mass::consistent);
  run.epsilon = entries.number("contact.epsilon");
  run.restitution = entries.number("contact.restitution");
  run.automatic = entries.text("method.name").value_or(std::string(automatic)) == automatic;
  run.method = chosen(entries, "method.name", all_methods, MethodName::cvode);
  const bool local = entries.text("method.error_control") == "local";
  run.tolerance = {number("method.relative_tolerance", Tolerance{}.relative),
                   entries.number("method.absolute_tolerance"), local ? ErrorControl::local : ErrorControl::global};
  run.stepper = chosen(entries, "method.stepper", all_steppers, Stepper::automatic);
  run.impact = entries.text("method.impact") == "moreau" ? Impact::moreau : Impact::paoli_schatzman;
  run.start = entries.text("method.start") == "second_order" ? Start::second_order : Start::first_order;

  run.end = number("time.end", 1.0);
  for (const std::string& key : entries.list("sensitivity.of")) {
    try {
      run.directions.push_back(direction_of(entries, run, key));
    } catch (const std::exception& refused) {
      entries.report("sensitivity.of", refused.what());
    }
  }
  if (run.automatic) {
    AutomaticMethod choice = automatic_method(run);
    run.method = choice.method;
    run.warning = std::move(choice.warning);
  }
  run.output_every = number("output.every", run.end / 100.0);
  run.files = files_of(entries);
  run.gauges = entries.numbers("output.gauges");
  run.step = entries.number("method.step");
  return run;
}

void check_end(SceneEntries& entries, const std::string& side) {
  const auto word = entries.text(side + ".kind");
  if (!word) return;
  for (const EndKind& kind : end_kinds) {
    if (kind.name != *word) continue;
    for (const EndNumber& number : kind.numbers)
      if (const std::string key = fmt::format("{}.{}", side, number.key); !entries.present(key) && !entries.faulty(key))
        entries.report(key, "is missing: {} has a {}, {}", kind.in_words, number.key, number.meaning);
  }
  for (const SceneKey& key : scene_keys()) {
    if (!key.name.starts_with(side) || key.table() != side) continue;  // this is asked for each case of a sweep
    const std::string_view leaf = key.leaf();
    if (leaf == "kind" || !entries.sound(key.name) || belongs_to_end(*word, leaf)) continue;
    const char* owner = belongs_to_end("free", leaf)       ? "a free end or an obstacle"
                        : belongs_to_end("obstacle", leaf) ? "an obstacle"
                                                           : "a fixed end";
    entries.report(key.name, "belongs to {}; this end is {}", owner, *word);
  }
}

void check_load_keys(SceneEntries& entries) {
  const bool density = entries.present("load.density");
  const bool profile = entries.present("load.profile"), history = entries.present("load.history");
  if (density && (profile || history))
    entries.report("load.density", "excludes load.profile and load.history: the load is one or the other");
  else if (!density && !profile && !history && entries.has_table("load") && !entries.faulty("load.density"))
    entries.report("load.density", "is missing: a load has a density, or a profile and a history");
  else if (profile != history)
    entries.report(profile ? "load.history" : "load.profile", "is missing: profile and history come together");
}

void check_side_keys(SceneEntries& entries) {
  if (!entries.has_table("side") || entries.present("side.stiffness") || entries.present("side.drag")) return;
  if (!entries.faulty("side.stiffness") && !entries.faulty("side.drag"))
    entries.report("side.stiffness", "is missing: what resists along the bar has a stiffness, a drag, or both");
}

// faults() asks this of the initial data; a load is not looked at before a run.
void check_load_values(SceneEntries& entries, const Mesh& mesh) {
  if (entries.faulty("bar.length")) return;
  for (const char* key : {"load.density", "load.profile", "load.history", "left.force", "right.force", "left.gap",
                          "right.gap", "left.motion", "right.motion"}) {
    const auto formula = entries.formula(key);
    if (!formula) continue;
    const SpaceTimeFunction f = formula->of_x_t();
    const std::size_t nodes = formula->uses('x') ? mesh.nodes() : 1;
    for (std::size_t j = 0; j < nodes; ++j) {
      const double x = mesh.node(j), value = f(x, 0.0);
      if (std::isfinite(value)) continue;
      const std::string where = formula->uses('x') ? fmt::format("x = {}, ", x) : "";
      entries.report(key, "is {} at {}t = 0", printable(value), where);
      break;
    }
  }
}

// A series says what the whole run asks for.
void check_series(SceneEntries& entries, const Case& run) {
  for (const std::string& name : entries.series_keys()) {
    const SceneKey& key = *find_scene_key(name);
    const auto series = entries.series(name);
    if (std::get<SceneTable>(entries.value(name)).contains("outside")) continue;
    const bool in_time = key.variables == "t", of_member = is_member_key(name);
    const std::string length = of_member ? fmt::format("{}.length", table_of(name)) : "bar.length";
    if (entries.faulty(in_time ? "time.end" : length) || (of_member && !entries.present(length))) continue;
    const double last = in_time ? run.end : of_member ? *entries.number(length) : run.scene.bar.length;
    if (series->first() > 0.0 || series->last() < last)
      entries.report(name,
                     "has values from {0} = {1} to {2}, and the {3} from 0 to {4}; outside = \"hold\" goes on with the "
                     "first and the last value, \"zero\" with 0",
                     key.variables, series->first(), series->last(), in_time ? "run goes" : "bar is", last);
    else if (constexpr double far = 100.0; in_time && series->last() > far * last)  // as of data of a fit
      entries.report(name,
                     "has values up to t = {:.6g}, and the run ends at {:.6g}: are they in different units, such as "
                     "milliseconds and seconds? If they are not, outside = \"hold\" takes the beginning",
                     series->last(), last);
  }
}

void check_motion(SceneEntries& entries) {
  const auto moves = [&](const char* key) {
    const auto formula = entries.formula(key);
    return entries.faulty(key) || (formula && !formula->is_constant());
  };
  for (std::size_t k = 1; k <= entries.members("bar"); ++k)
    for (const char* leaf : {"displacement", "velocity"})
      if (entries.given(fmt::format("bar.{}.{}", k, leaf))) return;
  if (entries.given("initial.displacement") || entries.given("initial.velocity") || entries.has_table("load") ||
      entries.present("left.force") || entries.present("right.force") || moves("left.motion") ||
      moves("right.motion") || moves("left.gap") || moves("right.gap"))
    return;
  entries.report("initial.displacement",
                 "is missing, and so are initial.velocity and a load: nothing would move the bar");
}

// The values of keys that the scene leaves out and the program chooses.
SceneValues choose(const SceneEntries& entries, const Setup& setup) {
  const Case& run = setup.run;
  SceneValues values;
  if (!entries.present("mesh.elements")) values.emplace_back("mesh.elements", static_cast<std::int64_t>(run.elements));
  if (!run.mass && run.method != MethodName::characteristics)
    values.emplace_back("mesh.mass", std::string(name(setup.mass)));
  if (is_penalised(run.method) && has_penalty(run.scene) && !run.epsilon)
    values.emplace_back("contact.epsilon", setup.epsilon);
  if (is_scheme(run.method) && !run.step) values.emplace_back("method.step", setup.step);
  return values;
}

void check_sensitivity(SceneEntries& entries, const Case& run) {
  if (run.directions.empty() || entries.faulty("method.name")) return;
  if (!method_row(run.method).differentiates)
    entries.report(
        "sensitivity.of",
        "{} has no derivatives, and derivatives are those of the motion that is computed: choose a method "
        "that has them, {}, whose motion is another one by its error",
        run.automatic ? fmt::format("{}, chosen for the scene,", name(run.method)) : std::string(name(run.method)),
        run.scene.span         ? "method.name = \"arkode\" (or cvode, ida) with a contact.epsilon"
        : has_stops(run.scene) ? "method.name = \"arkode\" (or cvode, ida)"
                               : "method.name = \"rigid\" (or cvode, ida, arkode)");
  std::set<std::string> seen;
  for (const Direction& along : run.directions) {
    if (!seen.insert(along.key).second) entries.report("sensitivity.of", "{} is given twice", along.key);
    if (along.key == "contact.epsilon" && !is_penalised(run.method))
      entries.report("sensitivity.of", "contact.epsilon: {} has no epsilon", name(run.method));
  }
}

// [contact] has a restitution for nothing where every obstacle has a law of its own.
void check_restitution(SceneEntries& entries, const Case& run) {
  if (!has_stops(run.scene) || has_penalty(run.scene) || entries.given("contact.speed")) return;
  if (entries.sound("contact.restitution"))
    entries.report(
        "contact.restitution",
        "belongs to the penalty and the rigid obstacle, and every obstacle here has a law of its own: leave it "
        "out, and give the law its damping, or hunt_crossley its restitution and speed");
}

Setup validated_setup(SceneEntries& entries, const Adaptation& adapt) {
  Case run = case_of(entries);
  if (adapt) {
    const MethodName before = run.method;
    adapt(run);
    run.automatic = run.automatic && run.method == before;
    if (!run.automatic) run.warning.clear();
  }
  check_sensitivity(entries, run);
  check_restitution(entries, run);
  check_series(entries, run);
  Setup setup = resolve(std::move(run));
  for (const Finding& finding : faults(setup, entries.faulty_keys())) entries.report(finding.key, finding.problem);
  check_load_values(entries, setup.mesh);
  return setup;
}

std::optional<AccuracyRequest> accuracy_of(SceneEntries& entries, const Setup& setup) {
  if (!entries.sound("accuracy.error")) return std::nullopt;
  AccuracyRequest request;
  const auto* text = std::get_if<std::string>(&entries.value("accuracy.error"));
  const auto share = text ? percentage(*text) : std::nullopt;
  request.relative = share.has_value();
  request.error = share ? *share : text ? *number_in<double>(*text) : *entries.number("accuracy.error");
  request.of = chosen(entries, "accuracy.of", all_goals, request.of);
  for (const auto& [key, given] : given_keys) request.given.*given = entries.given(key);
  if (setup.run.automatic) request.given.method = false;
  if (entries.diagnostics().empty())
    if (const auto found = fault(request, setup)) entries.report(found->key, found->problem);
  return request;
}

SceneValues describe(const SceneEntries& entries, const Case& run) {
  SceneValues values;
  for (const auto& [name, value] : entries.parameters()) values.emplace_back("parameters." + name, value);
  for (const SceneKey& key : scene_keys()) {
    const std::string name(key.name);
    if (!run.scene.chain.empty() && key.table() == "bar") {
      if (key.leaf() == "length") describe_chain(entries, run, values);
      continue;
    }
    if (name == "method.name")
      values.emplace_back(name, std::string(run.automatic ? automatic : viscobar::name(run.method)));
    else if (name == "output.every")
      values.emplace_back(name, run.output_every);
    else if (!entries.present(name) || is_parameter(name))
      continue;
    else if (key.type == KeyType::count)
      values.emplace_back(name, static_cast<std::int64_t>(run.elements));
    else
      values.emplace_back(name, entries.described(name));
  }
  return values;
}

std::string all_texts(const std::vector<Diagnostic>& found) {
  std::string all;
  for (const Diagnostic& one : found) all += (all.empty() ? "" : "\n") + one.text();
  return all;
}

SceneFile checked_scene(SceneEntries& entries, const Adaptation& adapt, Telling telling) {
  SceneFile scene;
  if (entries.readable()) {
    check_end(entries, "left");
    check_end(entries, "right");
    check_laws(entries);
    check_load_keys(entries);
    check_side_keys(entries);
    check_nodes(entries, "mesh", "bar.length");
    const bool has_bar = check_chain(entries);
    check_motion(entries);
    if (has_bar) {
      Setup setup = validated_setup(entries, adapt);
      scene.accuracy = accuracy_of(entries, setup);
      if (entries.diagnostics().empty() && telling == Telling::values) {
        scene.values = describe(entries, setup.run);
        scene.chosen = choose(entries, setup);
      }
      scene.run = std::move(setup.run);
    }
  }
  if (auto found = entries.diagnostics(); !found.empty()) throw SceneError(std::move(found));
  return scene;
}

}  // namespace

std::string Diagnostic::text() const {
  std::string where;
  if (!source.empty() && (line > 0 || key.empty())) where = source + ": ";
  if (!source.empty() && line > 0) where = fmt::format("{}:{}:{}: ", source, line, column);
  return fmt::format("{}{}{}{}", where, key, key.empty() ? "" : ": ", message);
}

SceneError::SceneError(std::vector<Diagnostic> found)
    : std::runtime_error(all_texts(found)), diagnostics(std::move(found)) {}

SceneFile parse_scene_with(const std::string& text, const std::string& source, std::span<const Setting> settings,
                           const Adaptation& adapt, Telling telling) {
  SceneEntries entries(text, source, settings);
  return checked_scene(entries, adapt, telling);
}

SceneFile parse_scene(const std::string& text, const std::string& source, std::span<const std::string> overrides,
                      const Adaptation& adapt) {
  return parse_scene_with(text, source, std::vector<Setting>(overrides.begin(), overrides.end()), adapt);
}

SceneFile read_scene(const std::filesystem::path& file, std::span<const std::string> overrides,
                     const Adaptation& adapt) {
  return parse_scene(input_text(file), file.string(), overrides, adapt);
}

}  // namespace viscobar
