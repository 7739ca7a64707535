#include "input/scene_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <list>
#include <map>

#include "case/method_table.hpp"
#include "input/input_text.hpp"
#include "scene/end_kinds.hpp"
#include "text/nearest_name.hpp"
#include "viscobar/case/accuracy.hpp"

namespace viscobar {

namespace {

using enum KeyType;
using enum Presence;

// Squares and products of three stay finite and normal within these bounds.
constexpr double smallest = 1e-100, largest = 1e100;
constexpr KeyRange positive{smallest, largest, "> 0"};
constexpr KeyRange not_negative{0.0, largest, ">= 0"};

// clang-format off
constexpr Choice steppers[] = {
    {"automatic", "rosenbrock4 or dopri5, by what their steps cost"},
    {"rosenbrock4", "linearly implicit, order 4"},
    {"dopri5", "explicit, order 5"},
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
constexpr std::string_view of_stiffness =
    "k of contact.law: N = k d, or k d^(3/2); the penalty has contact.epsilon instead";
constexpr std::string_view of_damping = "c of spring_damper, lambda of hunt_crossley";
constexpr std::string_view of_restitution =
    "instead of the damping of hunt_crossley: what is left of the speed of a lone mass that comes at contact.speed";
constexpr std::string_view of_speed =
    "of an impact after which hunt_crossley leaves contact.restitution of it, instead of a damping";

// The choices of ends, masses and methods, and the numbers of the ends, come from their own tables.
constexpr SceneKey rows[] = {
    {"title", text, optional, "", "\"A bar between two obstacles\"", "", "free text, for reports"},

    {"bar.length", number, required, "", "1.0", "length", "length L of the bar, 0 < x < L", positive},
    {"bar.density", number, optional, "1.0", "", "density", "rho", positive},
    {"bar.modulus", number, optional, "1.0", "", "stress", "E", positive},
    {"bar.viscosity", number, optional, "0.0", "0.01", "stress x time", "eta, the paper's alpha; 0 means that no damping term exists", not_negative},
    {"bar.section", formula, optional, "", "\"(2 - x)^2\"", "area", "A(x) > 0; absent: 1. Forces are A times stresses", positive, {}, "x"},

    {"left.kind", choice, required_in_table, "\"free\"", "\"obstacle\"", "", "condition at the end x = 0"},
    {"right.kind", choice, required_in_table, "\"free\"", "\"obstacle\"", "", "condition at the end x = L"},
    {"span.gap", number, required_in_table, "", "0.2", "length", "u(x,t) >= -gap along the whole bar, or as span.side says; without this table there is no such obstacle", not_negative},
    {"span.side", choice, optional, "", "\"below\"", "", "from where the obstacle bounds u; absent: below", {}, span_sides},

    {"initial.displacement", formula, optional, "0.0", "\"x*(1-x)\"", "length", "u_0; one of the two, or a load, must be there", {}, {}, "x"},
    {"initial.velocity", formula, optional, "0.0", "\"-x*(1-x)\"", "length / time", "u_1", {}, {}, "x"},

    {"load.density", formula, optional, "", "\"sin(t*sqrt(2))*cos(2*x)\"", "stress / length", "f, force per volume", {}, {}, "xt"},
    {"load.profile", formula, optional, "", "\"cos(2*x)\"", "stress / length", "f = profile history, instead of the density: evaluated once per node", {}, {}, "x"},
    {"load.history", formula, optional, "", "\"sin(t*sqrt(2))\"", "1", "f = profile history: evaluated once per step", {}, {}, "t"},

    {"side.stiffness", formula, optional, "", "3.0", "stress / length / length", "k, springs to the ground along the whole bar, a force -k u per volume, at rest at u = 0; a number or a formula in x", not_negative, {}, "x"},
    {"side.drag", formula, optional, "", "0.5", "stress x time / length / length", "c, drag along the whole bar, a force -c u_t per volume; a number or a formula in x", not_negative, {}, "x"},

    {"time.end", number, required, "", "6.0", "time", "T, the end of the run, which begins at t = 0", positive},

    {"mesh.elements", count, optional, "", "27", "1", "number of elements of equal length; absent: 100", {1.0, 1e8, "1 to 1e8"}},
    {"mesh.grading", number, optional, "1", "", "1", "ratio of the largest element to the smallest; elements shrink towards obstacles", {1.0, 1e6, "1 to 1e6"}},
    {"mesh.nodes", numbers, optional, "", "[0.0, 0.1, 0.3, 0.6, 1.0]", "length", "nodes of the mesh, rising from 0 to bar.length; with mesh.elements that many elements along the same lengths", not_negative},
    {"mesh.mass", choice, optional, "", "\"fourth_order\"", "", "mass matrix; absent: one whose contact nodes do not bounce by themselves, see below"},

    {"contact.epsilon", number, optional, "", "1e-6", "length / force", "reaction = penetration / epsilon, in penalised methods; absent: chosen by the accuracy of the mesh, see below", positive},
    {"contact.law", choice, optional, "", "\"spring_damper\"", "", "law of the stops at the ends, for methods that know it, absent: the penalty in penalised methods, a rigid obstacle in the others; an end's own law is left.contact or right.contact, see below"},
    {"contact.stiffness", number, optional, "", "100.0", "force / length, or / length^(3/2)", of_stiffness, positive},
    {"contact.damping", number, optional, "", "1.0", "force x time / length, or time / length", of_damping, not_negative},
    {"contact.speed", number, optional, "", "2.0", "length / time", of_speed, positive},
    {"contact.restitution", number, optional, "", "0.0", "1", "restitution of a contact node; absent: undamped spring in penalised methods, implicit constraint in the others", {0.0, 1.0, "0 to 1"}},

    {"method.name", choice, optional, "\"automatic\"", "\"automatic\"", "", "method of time integration"},
    {"method.relative_tolerance", number, optional, "1e-6", "", "1", "adaptive methods: error allowed, relative to the largest displacement and velocity", {1e-15, 0.1, ">= 1e-15, <= 0.1"}},
    {"method.absolute_tolerance", number, optional, "", "1e-9", "length", "adaptive methods: error allowed in addition, the same number for the velocity; absent: relative_tolerance / 1000 of the displacement and of the velocity that the scene has, see below", positive},
    {"method.error_control", choice, optional, "\"global\"", "", "", "whether the tolerances bound the error of the solution or of each step", {}, controls},
    {"method.stepper", choice, optional, "\"automatic\"", "", "", "formulas of odeint", {}, steppers},
    {"method.step", number, optional, "", "1e-3", "time", "time step of fully_discrete and finite_difference, absent: h / (100 c), time.end / 1000 at most", positive},
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
    {"output.gauges", numbers, optional, "", "[0.0, 0.25]", "length", "places x whose displacement, velocity, strain and stress gauges.csv has, in any order", not_negative},
};
// Keys of either end, beside its kind and its numbers.
constexpr SceneKey end_rows[] = {
    {"side", choice, optional, "", "\"below\"", "", "from where the obstacle bounds u; absent: below", {}, end_sides},
    {"force", formula, optional, "", "\"sin(2*t)\"", "force", "force on a free end or one with an obstacle, in the direction of u", {}, {}, "t"},
    {"motion", formula, optional, "", "\"0.1*sin(2*t)\"", "length", "motion d(t) of a fixed end, u = u_0 + d, with d(0) = 0", {}, {}, "t"},
    {"stiffness", number, optional, "", "2.0", "force / length", "spring between a free end, or one with an obstacle, and the ground, at rest at u = 0", not_negative},
    {"dashpot", number, optional, "", "0.1", "force x time / length", "dashpot beside that spring", not_negative},
    {"contact.law", choice, optional, "", "\"hertz\"", "", "law of the obstacle at this end, instead of that of [contact]"},
    {"contact.stiffness", number, optional, "", "100.0", "force / length, or / length^(3/2)", of_stiffness, positive},
    {"contact.damping", number, optional, "", "1.0", "force x time / length, or time / length", of_damping, not_negative},
    {"contact.restitution", number, optional, "", "0.5", "1", of_restitution, {0.0, 1.0, "0 to 1"}},
    {"contact.speed", number, optional, "", "2.0", "length / time", of_speed, positive},
    {"mass", number, optional, "", "2.0", "density x length x area", "rigid mass on a free end, or one with an obstacle; without a section per area of the bar", not_negative},
};
// Keys of each bar of several in line, and of the joint between it and the next.
constexpr SceneKey member_rows[] = {
    {"bar.length", number, optional, "", "1.0", "length", "length of a bar; a rigid body has a mass in its place", positive},
    {"bar.mass", number, optional, "", "2.0", "density x length x area", "mass of a rigid body, which has no length: a ram, a bit, a cap", positive},
    {"bar.density", number, optional, "1.0", "", "density", "rho", positive},
    {"bar.modulus", number, optional, "1.0", "", "stress", "E", positive},
    {"bar.viscosity", number, optional, "0.0", "0.01", "stress x time", "eta, the paper's alpha; 0 means that no damping term exists", not_negative},
    {"bar.section", formula, optional, "", "\"(2 - x)^2\"", "area", "A(x) > 0, x from the left end of this bar; absent: 1", positive, {}, "x"},
    {"bar.displacement", formula, optional, "", "0.0", "length", "u_0, x from the left end of this bar; absent: initial.displacement, x from that of the chain", {}, {}, "x"},
    {"bar.velocity", formula, optional, "", "1.0", "length / time", "u_1 likewise; absent: initial.velocity", {}, {}, "x"},
    {"bar.elements", count, optional, "", "50", "1", "elements of this bar; absent: by the time that a wave takes through it, all together mesh.elements", {1.0, 1e8, "1 to 1e8"}},
    {"bar.grading", number, optional, "", "4.0", "1", "ratio of the largest element of this bar to the smallest; elements shrink towards its contacts; absent: mesh.grading", {1.0, 1e6, "1 to 1e6"}},
    {"bar.nodes", numbers, optional, "", "[0.0, 0.1, 0.3, 0.6, 1.0]", "length", "nodes of this bar, rising from 0 to its length; with elements that many along the same lengths", not_negative},
    {"joint.kind", choice, required_in_table, "", "\"contact\"", "", "how a bar hangs together with the next; without a table they are bonded"},
    {"joint.gap", number, optional, "0.0", "0.05", "length", "between the two where nothing is displaced, of a contact", not_negative},
    {"joint.law", choice, optional, "", "\"hertz\"", "", "law of the contact, instead of that of [contact]"},
    {"joint.stiffness", number, optional, "", "100.0", "force / length, or / length^(3/2)", "k of a spring, or of the law of a contact", positive},
    {"joint.damping", number, optional, "", "1.0", "force x time / length, or time / length", "c of a dashpot beside the spring, or of the law of a contact", not_negative},
    {"joint.restitution", number, optional, "", "0.5", "1", of_restitution, {0.0, 1.0, "0 to 1"}},
    {"joint.speed", number, optional, "", "2.0", "length / time", of_speed, positive},
};
// clang-format on

constexpr std::string_view tables[] = {"bar",        "left",        "right", "span",    "initial", "load",
                                       "side",       "time",        "mesh",  "contact", "method",  "accuracy",
                                       "parameters", "sensitivity", "units", "output"};

constexpr std::string_view any_parameter = "parameters.NAME";

/// A name in viscobar, and its names in papers and other programs, in lower case.
struct Synonyms {
  std::string_view ours, theirs;
};
constexpr Synonyms synonyms[] = {
    {"viscosity", "alpha eta damping"},
    {"density", "rho force"},
    {"modulus", "young youngs youngs_modulus elasticity elastic_modulus e"},
    {"kind", "type"},
    {"length", "l"},
    {"displacement", "u u0"},
    {"velocity", "v v0"},
    {"gap", "position distance"},
    {"end", "t t_end duration"},
    {"elements", "j cells"},
    {"epsilon", "penalty compliance"},
    {"step", "dt h"},
    {"relative_tolerance", "rtol tolerance"},
    {"absolute_tolerance", "atol"},
    {"every", "interval dt_out"},
    {"obstacle", "wall contact signorini rigid"},
    {"fixed", "clamped dirichlet"},
    {"free", "none neumann"},
    {"lumped", "diagonal"},
    {"finite_difference", "fd"},
    {"odeint", "rk45"},
    {"method", "solver integrator"},
    {"bar", "material"},
    {"load", "forcing"},
};

/// "alpha" is the viscosity, "clamped" is fixed; the word itself when it is no synonym.
std::string_view usual_name(std::string_view word) {
  const std::string plain = plain_name(word);
  for (const auto& [ours, theirs] : synonyms)
    if (std::ranges::count(split(theirs, ' '), std::string_view(plain)) > 0) return ours;
  return word;
}

// The words of masses, goals, methods and kinds of ends, which have tables of their own.
std::span<const Choice> own_choices(std::string_view key) {
  static const auto all = [] {
    std::vector<Choice> masses, goals, ends, laws{{no_law, "that of contact.epsilon"}},
        methods{{automatic, "the method that suits the scene best, one for the whole run; summary.json names it"}};
    for (const Mass mass : all_masses) masses.push_back({name(mass), meaning(mass)});
    for (const Goal goal : all_goals) goals.push_back({name(goal), meaning(goal)});
    for (const MethodRow& row : method_table()) methods.push_back({row.name, row.meaning});
    for (const Law law : all_laws) laws.push_back({name(law), meaning(law)});
    for (const EndKind& kind : end_kinds) ends.push_back({kind.name, kind.meaning});
    std::vector<Choice> joints;
    for (const JointKind kind : all_joints) joints.push_back({name(kind), meaning(kind)});
    return std::map<std::string_view, std::vector<Choice>>{
        {"mesh.mass", masses},      {"accuracy.of", goals},      {"method.name", methods}, {"contact.law", laws},
        {"left.contact.law", laws}, {"right.contact.law", laws}, {"left.kind", ends},      {"right.kind", ends},
        {"joint.kind", joints},     {"joint.law", laws}};
  }();
  return all.at(key);
}

// The keys of an end but its kind, whose texts live as long as the program.
void add_end_keys(std::string_view end, std::vector<SceneKey>& keys) {
  static std::list<std::string> texts;
  const auto kept = [](std::string text) { return std::string_view(texts.emplace_back(std::move(text))); };
  const auto key = [&](std::string_view leaf) { return kept(fmt::format("{}.{}", end, leaf)); };
  for (const EndKind& kind : end_kinds)
    for (const EndNumber& of_end : kind.numbers) {
      const std::string meaning = fmt::format("{}; {} needs it, no other end has one", of_end.meaning, kind.in_words);
      const KeyRange range{of_end.low, of_end.high, of_end.range};
      keys.push_back({key(of_end.key), formula, optional, "", "0.1", of_end.unit, kept(meaning), range, {}, "t"});
    }
  for (SceneKey row : end_rows) {
    row.name = key(row.name);
    if (row.type == choice && row.choices.empty()) row.choices = own_choices(row.name);
    keys.push_back(row);
  }
}

}  // namespace

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

std::span<const SceneKey> member_keys() {
  static const auto keys = [] {
    std::vector<SceneKey> all(std::begin(member_rows), std::end(member_rows));
    for (SceneKey& key : all)
      if (key.type == choice) key.choices = own_choices(key.name);
    return all;
  }();
  return keys;
}

bool is_member_table(std::string_view name) {
  const std::size_t dot = name.find('.');
  const std::string_view number = dot == name.npos ? std::string_view{} : name.substr(dot + 1);
  const std::string_view table = name.substr(0, dot);
  return (table == "bar" || table == "joint") && !number.empty() && number.size() < 7 && number.front() != '0' &&
         std::ranges::all_of(number, is_digit);
}

bool is_member_key(std::string_view name) {
  const std::size_t dot = name.find('.'), second = dot == name.npos ? dot : name.find('.', dot + 1);
  return second != name.npos && is_member_table(name.substr(0, second));
}

std::string_view table_of(std::string_view name) {
  const std::size_t dot = name.find('.');
  if (dot == name.npos) return {};
  return name.substr(0, is_member_key(name) ? name.find('.', dot + 1) : dot);
}

bool is_inner_table(std::string_view name) {
  return name.find('.') != name.npos && std::ranges::any_of(scene_keys(), [&](const SceneKey& key) {
           return key.name.size() > name.size() && key.name.starts_with(name) && key.name[name.size()] == '.';
         });
}

std::string_view parameter_name(std::string_view name) { return name.substr(name.find('.') + 1); }

bool is_parameter(std::string_view name) { return name.starts_with("parameters.") && !parameter_name(name).empty(); }

std::span<const std::string_view> scene_tables() { return tables; }

bool is_scene_table(std::string_view name) {
  return std::ranges::find(tables, name) != std::end(tables) || is_member_table(name);
}

const SceneKey* find_plain_key(std::string_view name) {
  // A case of a sweep asks 200 times. The last eight characters and the length tell most keys apart.
  static constexpr std::size_t size = 512;
  const auto place = [](std::string_view of) {
    std::uint64_t end = 0;
    const std::size_t count = std::min(of.size(), sizeof end);
    std::memcpy(&end, of.data() + of.size() - count, count);
    return ((end + of.size()) * 0x9E3779B97F4A7C15u) >> 55;
  };
  static const auto table = [&] {
    std::array<const SceneKey*, size> all{};
    for (const SceneKey& key : scene_keys()) {
      std::size_t at = place(key.name);
      while (all[at]) at = (at + 1) % size;
      all[at] = &key;
    }
    return all;
  }();
  for (std::size_t at = place(name); table[at]; at = (at + 1) % size)
    if (table[at]->name == name) return table[at];
  return nullptr;
}

const SceneKey* find_scene_key(std::string_view name) {
  if (const SceneKey* plain = find_plain_key(name)) return plain;
  if (is_parameter(name)) return find_plain_key(any_parameter);
  if (!is_member_key(name)) return nullptr;
  const std::string_view table = name.substr(0, name.find('.')), leaf = name.substr(table_of(name).size() + 1);
  const auto found = std::ranges::find_if(
      member_keys(), [&](const SceneKey& key) { return key.table() == table && key.leaf() == leaf; });
  return found == member_keys().end() ? nullptr : &*found;
}

const SceneKey* find_scene_key(std::string_view table, std::string_view leaf) {
  if (table == "parameters" && !leaf.empty()) return find_scene_key(any_parameter);
  if (table.empty() && leaf.find('.') != leaf.npos) return nullptr;  // a key in quotes
  return find_scene_key(table.empty() ? std::string(leaf) : fmt::format("{}.{}", table, leaf));
}

std::optional<std::string_view> meant_name(std::string_view word, std::span<const std::string_view> candidates) {
  const std::string_view usual = usual_name(word);
  if (const auto found = std::ranges::find(candidates, usual); found != candidates.end()) return *found;
  const auto nearest = nearest_name(word, candidates);
  if (nearest) return nearest;
  // The beginning of one alone.
  const auto begun = [&](std::string_view candidate) { return word.size() > 2 && candidate.starts_with(word); };
  if (std::ranges::count_if(candidates, begun) == 1) return *std::ranges::find_if(candidates, begun);
  return nearest_name(usual, candidates);
}

const SceneKey* nearest_scene_key(std::string_view table, std::string_view leaf,
                                  const std::function<bool(const SceneKey&)>& takes) {
  const std::span<const SceneKey> keys = is_member_table(table) ? member_keys() : scene_keys();
  if (is_member_table(table)) table = table.substr(0, table.find('.'));
  const auto near = [&](bool of_its_type) {
    std::vector<std::string_view> siblings;
    for (const SceneKey& key : keys)
      if ((key.table() == table || table.empty()) && (!of_its_type || takes(key))) siblings.push_back(key.leaf());
    return meant_name(leaf, siblings);
  };
  auto nearest = near(true);
  if (!nearest) nearest = near(false);  // a slip in the value beside one in the name
  const std::string_view usual = usual_name(leaf);
  const auto found = std::ranges::find_if(keys, [&](const SceneKey& key) {
    if (nearest) return key.leaf() == *nearest && (table.empty() || key.table() == table);
    return (key.leaf() == leaf || key.leaf() == usual) && takes(key);
  });
  return found == keys.end() ? nullptr : &*found;
}

}  // namespace viscobar
