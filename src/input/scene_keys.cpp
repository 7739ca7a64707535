#include "input/scene_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <list>
#include <unordered_map>
#include <vector>

#include "case/method_table.hpp"
#include "input/synonyms.hpp"
#include "scene/end_kinds.hpp"
#include "text/nearest_name.hpp"
#include "viscobar/case/accuracy.hpp"

namespace viscobar {

namespace {

using enum KeyType;
using enum Presence;

// Squares and products of three stay finite and normal within these bounds.
constexpr double smallest = 1e-100, largest = 1e100;
constexpr Range positive{smallest, largest, "> 0"};
constexpr Range not_negative{0.0, largest, ">= 0"};

// clang-format off
constexpr Choice steppers[] = {
    {"automatic", "rosenbrock4 or dopri5, by what their steps cost"},
    {"rosenbrock4", "linearly implicit, order 4, dense matrices: few nodes"},
    {"dopri5", "explicit, order 5"},
    {"symplectic", "explicit, order 4, steps of method.step; no viscosity"},
};
constexpr Choice starts[] = {
    {"first_order", "u_0 + dt u_1"},
    {"second_order", "u_0 + dt u_1 + dt^2/2 u''"},
};
constexpr Choice impacts[] = {
    {"paoli_schatzman", "(u^{n+1} + e u^{n-1}) / (1 + e) is bounded"},
    {"moreau", "the velocity after an impact is bounded, which never gives energy"},
};
constexpr Choice end_sides[] = {
    {"below", "u >= -gap: at the left end a wall on the left, at the right end one that draws along"},
    {"above", "u <= gap: at the right end a wall on the right"},
};
constexpr Choice span_sides[] = {
    {"below", "u >= -gap"},
    {"above", "u <= gap"},
    {"both", "-gap <= u <= gap, a slit"},
};
constexpr Choice controls[] = {
    {"global", "the error of the solution"},
    {"local", "the error of each step"},
};
constexpr Choice files[] = {
    {"ends", "ends.csv, the motion of the ends"},
    {"events", "events.csv, the contact changes"},
    {"field", "field.h5 and field.xdmf, displacement, velocity and stress of the whole bar"},
    {"energy", "energy.csv, where the energy is"},
    {"report", "report.html, the page with the pictures"},
};
constexpr Choice formulas[] = {
    {"automatic", "chosen leg by leg, by the bar's stiffness"},
    {"adams", "Adams-Moulton, for bars that are not stiff"},
    {"bdf", "backward differentiation, for stiff ones"},
};

// The choices of ends, masses and methods, and the numbers of the ends, come from their own tables.
constexpr SceneKey rows[] = {
    {"title", text, optional, "", "\"A bar between two obstacles\"", "", "free text, for reports"},

    {"bar.length", number, required, "", "1.0", "length", "length L of the bar, 0 < x < L", positive},
    {"bar.density", number, optional, "1.0", "", "density", "rho", positive},
    {"bar.modulus", number, optional, "1.0", "", "stress", "E", positive},
    {"bar.viscosity", number, optional, "0.0", "0.01", "stress x time", "eta, the paper's alpha; 0 means that no damping term exists", not_negative},

    {"left.kind", choice, required_in_table, "\"free\"", "\"obstacle\"", "", "condition at the end x = 0"},
    {"right.kind", choice, required_in_table, "\"free\"", "\"obstacle\"", "", "condition at the end x = L"},
    {"span.gap", number, required_in_table, "", "0.2", "length", "u(x,t) >= -gap along the whole bar, or as span.side says; without this table there is no such obstacle", not_negative},
    {"span.side", choice, optional, "", "\"below\"", "", "from where the obstacle bounds u; absent: below", {}, span_sides},

    {"initial.displacement", formula, optional, "0.0", "\"x*(1-x)\"", "length", "u_0; one of the two, or a load, must be there", {}, {}, "x"},
    {"initial.velocity", formula, optional, "0.0", "\"-x*(1-x)\"", "length / time", "u_1", {}, {}, "x"},

    {"load.density", formula, optional, "", "\"sin(t*sqrt(2))*cos(2*x)\"", "stress / length", "f, force per volume", {}, {}, "xt"},
    {"load.profile", formula, optional, "", "\"cos(2*x)\"", "stress / length", "f = profile history, instead of the density: evaluated once per node", {}, {}, "x"},
    {"load.history", formula, optional, "", "\"sin(t*sqrt(2))\"", "1", "f = profile history: evaluated once per step", {}, {}, "t"},

    {"time.end", number, required, "", "6.0", "time", "T, the end of the run, which begins at t = 0", positive},

    {"mesh.elements", count, optional, "", "27", "1", "number of elements of equal length; absent: 100", {1.0, 1e8, "1 to 1e8"}},
    {"mesh.grading", number, optional, "1", "", "1", "ratio of the largest element to the smallest; elements shrink towards obstacles", {1.0, 1e6, "1 to 1e6"}},
    {"mesh.mass", choice, optional, "", "\"fourth_order\"", "", "mass matrix; absent: one whose contact nodes do not bounce by themselves, see below"},

    {"contact.epsilon", number, optional, "", "1e-6", "length / stress", "reaction = penetration / epsilon, in penalised methods; absent: chosen by the accuracy of the mesh, see below", positive},
    {"contact.restitution", number, optional, "", "0.0", "1", "restitution of a contact node; absent: undamped spring in penalised methods, implicit constraint in the others", {0.0, 1.0, "0 to 1"}},

    {"method.name", choice, optional, "\"automatic\"", "\"automatic\"", "", "method of time integration"},
    {"method.relative_tolerance", number, optional, "1e-6", "", "1", "adaptive methods: error allowed, relative to the largest displacement and velocity", {1e-15, 0.1, ">= 1e-15, <= 0.1"}},
    {"method.absolute_tolerance", number, optional, "", "1e-9", "length", "adaptive methods: error allowed in addition, the same number for the velocity; absent: relative_tolerance / 1000 of the displacement and of the velocity that the scene has, see below", positive},
    {"method.error_control", choice, optional, "\"global\"", "", "", "whether the tolerances bound the error of the solution or of each step", {}, controls},
    {"method.formulas", choice, optional, "\"automatic\"", "", "", "multistep formulas of cvode", {}, formulas},
    {"method.stepper", choice, optional, "\"automatic\"", "", "", "formulas of odeint", {}, steppers},
    {"method.step", number, optional, "", "1e-3", "time", "time step of fully_discrete and finite_difference, absent: h / (100 c), and of odeint's symplectic stepper, which needs it", positive},
    {"method.start", choice, optional, "\"first_order\"", "", "", "first step of the two schemes: u_0 + dt u_1, or with the term dt^2/2 u'' too", {}, starts},
    {"method.impact", choice, optional, "\"paoli_schatzman\"", "", "", "law of restitution of the two schemes: a bound on the mean of displacements, or on the velocity, which never gives energy", {}, impacts},

    {"accuracy.error", amount, required_in_table, "", "1e-4", "of what `accuracy.of` names", "the error that is bearable: method, mass, elements, epsilon and tolerance are chosen for it where the scene leaves them out; a number, or a percentage of the largest value, such as \"0.01 %\"", positive},
    {"accuracy.of", choice, optional, "", "\"displacement\"", "", "what it is an error of; absent: displacement"},

    {"parameters.NAME", number, optional, "", "", "", "a number that formulas may use by its name, such as amplitude", {-largest, largest, ""}},

    {"sensitivity.of", list, optional, "", "", "", "keys with respect to which derivatives of the whole result are told, such as bar.viscosity; also --sensitivity"},

    {"units.length", text, optional, "", "\"m\"", "", "name of the unit of length, such as \"m\", for axes and attributes"},
    {"units.time", text, optional, "", "\"s\"", "", "likewise of time, such as \"s\""},
    {"units.mass", text, optional, "", "\"kg\"", "", "likewise of mass, such as \"kg\""},
    {"units.force", text, optional, "", "\"N\"", "", "likewise of force, such as \"N\""},
    {"units.stress", text, optional, "", "\"Pa\"", "", "likewise of stress, such as \"Pa\"; absent: made of force and length, or of mass, length and time"},

    {"output.every", number, optional, "", "0.01", "time", "interval of the output times; absent: time.end / 100", positive},
    {"output.write", list, optional, "", "[\"ends\", \"events\", \"field\", \"energy\", \"report\"]", "", "files to write beside summary.json; absent: all", {}, files},
};
// Of either end, beside its kind and its numbers.
constexpr SceneKey end_rows[] = {
    {"side", choice, optional, "", "\"below\"", "", "from where the obstacle bounds u; absent: below", {}, end_sides},
    {"force", formula, optional, "", "\"sin(2*t)\"", "stress", "force on a free end or one with an obstacle, in the direction of u", {}, {}, "t"},
    {"motion", formula, optional, "", "\"0.1*sin(2*t)\"", "length", "motion d(t) of a fixed end, u = u_0 + d, with d(0) = 0", {}, {}, "t"},
    {"stiffness", number, optional, "", "2.0", "stress / length", "spring between a free end, or one with an obstacle, and the ground, at rest at u = 0", not_negative},
    {"dashpot", number, optional, "", "0.1", "stress x time / length", "dashpot beside that spring", not_negative},
};
// clang-format on

constexpr std::string_view tables[] = {"bar",      "left",       "right",       "span",    "initial",
                                       "load",     "time",       "mesh",        "contact", "method",
                                       "accuracy", "parameters", "sensitivity", "units",   "output"};

constexpr std::string_view any_parameter = "parameters.NAME";

template <class Rows, class Word>
std::vector<Choice> choices_of(const Rows& rows_of_all, Word word) {
  std::vector<Choice> choices;
  for (const auto& row : rows_of_all) choices.push_back(word(row));
  return choices;
}

std::span<const Choice> own_choices(std::string_view key) {
  static const auto masses = choices_of(all_masses, [](Mass mass) { return Choice{name(mass), meaning(mass)}; });
  static const auto goals = choices_of(all_goals, [](Goal goal) { return Choice{name(goal), meaning(goal)}; });
  static constexpr auto words = [](const auto& row) { return Choice{row.name, row.meaning}; };
  static const auto ends = choices_of(end_kinds, words);
  static const auto methods = [] {
    auto all = choices_of(method_table(), words);
    all.insert(all.begin(),
               {automatic, "the method that suits the scene best, one for the whole run; summary.json names it"});
    return all;
  }();
  if (key == "mesh.mass") return masses;
  if (key == "accuracy.of") return goals;
  return key == "method.name" ? methods : ends;
}

// The keys of an end but its kind, whose texts live as long as the program.
void add_end_keys(std::string_view end, std::vector<SceneKey>& keys) {
  static std::list<std::string> texts;
  const auto kept = [](std::string text) { return std::string_view(texts.emplace_back(std::move(text))); };
  const auto key = [&](std::string_view leaf) { return kept(fmt::format("{}.{}", end, leaf)); };
  for (const EndKind& kind : end_kinds)
    for (const EndNumber& of_end : kind.numbers) {
      const std::string meaning = fmt::format("{}; {} needs it, no other end has one", of_end.meaning, kind.in_words);
      const Range range{of_end.low, of_end.high, of_end.range};
      keys.push_back({key(of_end.key), formula, optional, "", "0.1", of_end.unit, kept(meaning), range, {}, "t"});
    }
  for (SceneKey row : end_rows) {
    row.name = key(row.name);
    keys.push_back(row);
  }
}

template <class Condition>
const SceneKey* first_key(Condition condition) {
  const auto keys = scene_keys();
  const auto found = std::find_if(keys.begin(), keys.end(), condition);
  return found == keys.end() ? nullptr : &*found;
}

}  // namespace

std::string type_words(const SceneKey& key) {
  switch (key.type) {
    case text: return "text";
    case choice: return fmt::format("`{}`", fmt::join(key.choice_names(), "`, `"));
    case number: return key.range.words.empty() ? "number" : fmt::format("number {}", key.range.words);
    case count: return fmt::format("whole number {}", key.range.words);
    case amount: return fmt::format("number {}, or percentage in quotes", key.range.words);
    case formula:
      return fmt::format("number{}{}, or formula in {}", key.range.words.empty() ? "" : " ", key.range.words,
                         key.variables == "xt" ? "x and t" : key.variables);
    case list:
      return key.choices.empty() ? "list of keys" : fmt::format("list of `{}`", fmt::join(key.choice_names(), "`, `"));
  }
  return {};
}

std::string default_words(const SceneKey& key) {
  if (key.presence == required) return "required";
  const std::string value = key.fallback.empty() ? "none" : fmt::format("`{}`", key.fallback);
  if (key.presence == optional) return value;
  return fmt::format("required in `[{}]`{}", key.table(), key.fallback.empty() ? "" : ", else " + value);
}

std::string_view SceneKey::table() const {
  const std::size_t dot = name.find('.');
  return dot == name.npos ? std::string_view{} : name.substr(0, dot);
}

std::string_view SceneKey::leaf() const { return name.substr(name.find('.') + 1); }

std::vector<std::string_view> SceneKey::choice_names() const {
  std::vector<std::string_view> names;
  for (const Choice& known : choices) names.push_back(known.name);
  return names;
}

std::span<const SceneKey> scene_keys() {
  static const auto keys = [] {
    std::vector<SceneKey> all;
    for (SceneKey key : rows) {
      if (key.type == choice && key.choices.empty()) key.choices = own_choices(key.name);
      all.push_back(key);
      if (key.leaf() == "kind") add_end_keys(key.table(), all);
    }
    return all;
  }();
  return keys;
}

bool is_parameter(std::string_view name) {
  constexpr std::string_view table = "parameters.";
  return name.size() > table.size() && name.starts_with(table);
}

std::span<const std::string_view> scene_tables() { return tables; }

bool is_scene_table(std::string_view name) {
  return std::find(std::begin(tables), std::end(tables), name) != std::end(tables);
}

const SceneKey* find_scene_key(std::string_view name) {
  if (is_parameter(name)) name = any_parameter;
  static const auto by_name = [] {
    std::unordered_map<std::string_view, const SceneKey*> all;
    for (const SceneKey& key : scene_keys()) all.emplace(key.name, &key);
    return all;
  }();
  const auto found = by_name.find(name);
  return found == by_name.end() ? nullptr : found->second;
}

const SceneKey* find_scene_key(std::string_view table, std::string_view leaf) {
  if (table == "parameters" && !leaf.empty()) return find_scene_key(any_parameter);
  if (leaf.find('.') != leaf.npos) return nullptr;  // a key in quotes
  return find_scene_key(table.empty() ? std::string(leaf) : fmt::format("{}.{}", table, leaf));
}

const SceneKey* nearest_scene_key(std::string_view table, std::string_view leaf) {
  std::vector<std::string_view> siblings;
  for (const SceneKey& key : scene_keys())
    if (key.table() == table || table.empty()) siblings.push_back(key.leaf());
  const auto nearest = meant_name(leaf, siblings);
  if (nearest && !table.empty()) return find_scene_key(table, *nearest);
  if (nearest) return first_key([&](const SceneKey& key) { return key.leaf() == *nearest; });
  const std::string_view usual = usual_name(leaf);
  return first_key([&](const SceneKey& key) { return key.leaf() == leaf || key.leaf() == usual; });
}

}  // namespace viscobar
