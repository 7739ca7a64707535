#include "input/scene_chain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "case/scene_numbers.hpp"
#include "input/scene_stop.hpp"

namespace viscobar {

namespace {

// The table for what a bar in line has of its own, where there is one bar alone.
std::string_view table_of_own(std::string_view leaf) {
  if (leaf == "elements" || leaf == "nodes" || leaf == "grading") return "mesh";
  return leaf == "displacement" || leaf == "velocity" ? "initial" : "";
}

// Moves it there, where it counts before what the scene says of all bars.
void give_to_scene(TomlNode& root, std::size_t bar) {
  const std::vector<TomlNode> all = std::exchange(root.inside[bar].inside, {});
  for (const TomlNode& entry : all) {
    const std::string_view table = table_of_own(entry.key);
    if (table.empty()) {
      root.inside[bar].inside.push_back(entry);
      continue;
    }
    auto to = std::ranges::find(root.inside, table, &TomlNode::key);
    if (to == root.inside.end()) {
      root.inside.push_back(
          {std::string(table), TomlNode::Kind::table, root.inside[bar].value, {}, entry.key_at, entry.key_at});
      to = root.inside.end() - 1;
    }
    std::erase_if(to->inside, [&](const TomlNode& one) { return one.key == entry.key; });
    to->inside.push_back(entry);
  }
}

std::string key_of(std::string_view table, std::size_t number, std::string_view leaf) {
  return fmt::format("{}.{}.{}", table, number, leaf);
}

JointKind kind_of(const SceneEntries& entries, std::size_t number) {
  const auto word = entries.text(key_of("joint", number, "kind"));
  for (const JointKind kind : all_joints)
    if (word == name(kind)) return kind;
  return JointKind::bonded;
}

void check_member(SceneEntries& entries, std::size_t number) {
  const auto key = [&](std::string_view leaf) { return key_of("bar", number, leaf); };
  if (entries.faulty(key("length")) || entries.faulty(key("mass"))) return;
  if (entries.present(key("length"))) {
    if (entries.present(key("mass")))
      entries.report(key("mass"), "belongs to a rigid body, which has no length; a bar has a density");
    return;
  }
  if (!entries.present(key("mass")))
    return entries.report(key("length"), "is missing: a bar has a length, and a rigid body a mass in its place");
  for (const char* leaf : {"density", "modulus", "viscosity", "section", "elements", "grading", "nodes"})
    if (entries.present(key(leaf))) entries.report(key(leaf), "belongs to a bar; this is a rigid body, by its mass");
  for (const char* leaf : {"displacement", "velocity"})
    if (const auto formula = entries.formula(key(leaf)); formula && !formula->is_constant())
      entries.report(key(leaf), "varies along a bar; that of a rigid body is a number");
}

void check_joint(SceneEntries& entries, std::size_t number) {
  const auto key = [&](std::string_view leaf) { return key_of("joint", number, leaf); };
  if (entries.faulty(key("kind"))) return;
  if (!entries.present(key("kind")))
    return entries.report(key("kind"), "is missing: a joint is \"bonded\", a \"contact\" or a \"spring\"");
  const JointKind kind = kind_of(entries, number);
  const auto refuse = [&](std::initializer_list<const char*> leaves, const char* owner) {
    for (const char* leaf : leaves)
      if (entries.sound(key(leaf))) entries.report(key(leaf), "belongs to {}; this joint is {}", owner, name(kind));
  };
  if (kind != JointKind::contact) refuse({"gap", "law", "restitution", "speed"}, "a contact");
  if (kind == JointKind::bonded) refuse({"stiffness", "damping"}, "a spring or the law of a contact");
  if (kind == JointKind::spring && !entries.present(key("stiffness")) && !entries.faulty(key("stiffness")))
    entries.report(key("stiffness"), "is missing: a spring has one");
}

// A function of one member: its own formula of x from its left end, or that of [initial] of x along the chain.
struct Part {
  double begin, length, shift;
  SpaceFunction function;  // of x from the left end of the member
  Places places;           // of the formula
};

NextBreak joined(const std::vector<Part>& parts, NextBreak Places::*which, bool with_joints) {
  return [parts, which, with_joints](double after, double until) -> std::optional<double> {
    for (const Part& part : parts) {
      if (with_joints && part.begin > std::max(after, 0.0) && part.begin < until) return part.begin;
      const double from = std::max(after, part.begin), to = std::min(until, part.begin + part.length);
      const NextBreak& breaks = part.places.*which;
      if (!breaks || !(from < to)) continue;
      auto next = breaks(from - part.shift, to - part.shift);
      // A place within a rounding of it is the place that was told last, by the shift, or the end of the part before.
      const double rounding = 64.0 * std::numeric_limits<double>::epsilon() * to;
      if (next && *next + part.shift <= from + rounding) next = breaks(from + rounding - part.shift, to - part.shift);
      if (next && *next + part.shift > from) return *next + part.shift;
    }
    return std::nullopt;
  };
}

std::vector<Part> parts_of(const SceneEntries& entries, const std::vector<Member>& chain, const char* leaf,
                           double length) {
  const auto whole = entries.formula(fmt::format("initial.{}", leaf)).value_or(Formula(0.0));
  const SpaceFunction of_whole = whole.of_x();
  std::vector<Part> parts;
  double begin = 0.0;
  for (std::size_t m = 0; m < chain.size(); ++m) {
    const double own_length = chain[m].bar.length;
    if (const auto own = entries.formula(key_of("bar", m + 1, leaf)))
      parts.push_back({begin, own_length, begin, own->of_x(), own->places(own_length)});
    else
      parts.push_back(
          {begin, own_length, 0.0, [of_whole, begin](double x) { return of_whole(begin + x); }, whole.places(length)});
    begin += own_length;
  }
  return parts;
}

}  // namespace

void number_members(TomlNode& root) {
  std::vector<TomlNode> all;
  std::optional<std::size_t> only;
  for (TomlNode& node : root.inside) {
    if (!(node.key == "bar" || node.key == "joint") || !node.is_list_of_tables()) {
      all.push_back(std::move(node));
      continue;
    }
    const bool alone = node.key == "bar" && node.inside.size() == 1;
    if (alone) only = all.size();
    for (std::size_t k = 0; k < node.inside.size(); ++k) {
      TomlNode& member = node.inside[k];
      member.key = alone ? "bar" : fmt::format("{}.{}", node.key, k + 1);
      all.push_back(std::move(member));
    }
  }
  root.inside = std::move(all);
  if (only) give_to_scene(root, *only);
}

std::shared_ptr<const std::vector<double>> nodes_of(const SceneEntries& entries, const std::string& key,
                                                    double length) {
  std::vector<double> nodes = entries.numbers(key);
  if (nodes.size() < 2 || nodes.back() != length) return nullptr;
  for (double& node : nodes) node /= length;
  return std::make_shared<const std::vector<double>>(std::move(nodes));
}

void check_nodes(SceneEntries& entries, const std::string& table, const std::string& length_key) {
  const std::string key = table + ".nodes", grading = table + ".grading";
  if (!entries.present(key) || entries.faulty(key)) return;
  const std::vector<double> nodes = entries.numbers(key);
  const double length = entries.number(length_key).value_or(0.0), closest = 1e-6 * length;
  const auto fall =
      std::ranges::adjacent_find(nodes, [closest](double a, double b) { return b <= a || b - a < closest; });
  if (nodes.size() < 2)
    entries.report(key, "needs both ends of the bar at least, 0 and {}", length_key);
  else if (fall != nodes.end())
    entries.report(key, "must rise by 1e-6 of {} at least, and {} follows {}", length_key, fall[1], fall[0]);
  else if (length > 0.0 && (nodes.front() != 0.0 || nodes.back() != length))
    entries.report(key, "must go from 0 to {} = {}, and go from {} to {}", length_key, length, nodes.front(),
                   nodes.back());
  if (entries.number(grading).value_or(1.0) != 1.0)
    entries.report(grading, "does not go with {}, which say where elements are small", key);
}

namespace {

// Nodes and gradings as each bar asks for them, and elements; the other bars get as many in the time of a wave as the
// finest, or all share [mesh] by it.
std::vector<Mesh> meshes_of(const SceneEntries& entries, const std::vector<Member>& chain) {
  std::vector<Mesh> meshes(chain.size(), Mesh{0.0, 0});
  std::vector<double> transits(chain.size(), 0.0);
  double density = 0.0;
  for (std::size_t m = 0; m < chain.size(); ++m) {
    const Bar& bar = chain[m].bar;
    if (chain[m].rigid()) continue;
    transits[m] = bar.transit();
    const auto number = [&](const char* leaf) { return entries.number(key_of("bar", m + 1, leaf)); };
    meshes[m].given = nodes_of(entries, key_of("bar", m + 1, "nodes"), bar.length);
    if (!meshes[m].given)
      meshes[m].grading.ratio = number("grading").value_or(entries.number("mesh.grading").value_or(1.0));
    meshes[m].elements = static_cast<std::size_t>(
        number("elements").value_or(meshes[m].given ? static_cast<double>(meshes[m].given->size() - 1) : 0.0));
    density = std::max(density, static_cast<double>(meshes[m].elements) / transits[m]);
  }
  const double time = std::accumulate(transits.begin(), transits.end(), 0.0);
  if (density == 0.0) density = entries.number("mesh.elements").value_or(default_elements) / time;
  constexpr double fewest = 4.0;  // in a bar that says nothing: a row of each end and one between
  for (std::size_t m = 0; m < chain.size(); ++m)
    if (!chain[m].rigid() && meshes[m].elements == 0)
      meshes[m].elements = static_cast<std::size_t>(std::max(fewest, std::round(density * transits[m])));
  return meshes;
}

}  // namespace

bool check_chain(SceneEntries& entries) {
  const std::size_t count = entries.members("bar"), joints = entries.members("joint");
  entries.report_members_apart();
  if (count == 0) {
    for (std::size_t k = 1; k <= joints; ++k)
      entries.report(key_of("joint", k, "kind"), "is between two tables [[bar]], and there is one bar");
    return true;
  }
  std::size_t bars = 0;
  for (std::size_t k = 1; k <= count; ++k) {
    check_member(entries, k);
    bars += entries.present(key_of("bar", k, "length")) || entries.faulty(key_of("bar", k, "length"));
    check_nodes(entries, fmt::format("bar.{}", k), key_of("bar", k, "length"));
  }
  if (bars == 0) entries.report("bar.1.length", "is missing: rigid bodies alone are no bars");
  for (std::size_t k = 1; k <= joints; ++k)
    if (k < count)
      check_joint(entries, k);
    else
      entries.report(key_of("joint", k, "kind"), "is the joint behind bar {}, and there are {} bars", k, count);
  for (const char* leaf : {"length", "density", "modulus", "viscosity", "section"})
    if (const std::string key = fmt::format("bar.{}", leaf); entries.given(key))
      entries.report(key, "says not which of {} bars: write {}", count, key_of("bar", 1, leaf));
  if (entries.present("mesh.nodes"))
    entries.report("mesh.nodes", "says not which of {} bars: write {}", count, key_of("bar", 1, "nodes"));
  return bars > 0;
}

void take_chain(const SceneEntries& entries, Case& run) {
  const std::size_t count = entries.members("bar");
  if (count == 0) return;
  Scene& scene = run.scene;
  for (std::size_t k = 1; k <= count; ++k) {
    const auto number = [&](std::string_view leaf, double otherwise) {
      return entries.number(key_of("bar", k, leaf)).value_or(otherwise);
    };
    Member member;
    member.mass = number("mass", 0.0);
    if (member.mass == 0.0)
      member.bar = {number("length", 1.0), number("density", 1.0), number("modulus", 1.0), number("viscosity", 0.0)};
    else
      member.bar = {0.0, 1.0, 1.0, 0.0};
    if (const auto section = entries.formula(key_of("bar", k, "section")); section && !member.rigid())
      member.section = section->of_x(), member.section_places = section->places(member.bar.length);
    if (k < count) {
      const auto of_joint = [&](std::string_view leaf) {
        return entries.number(key_of("joint", k, leaf)).value_or(0.0);
      };
      Joint& joint = member.joint;
      joint.kind = kind_of(entries, k);
      joint.gap = of_joint("gap");
      if (joint.kind == JointKind::contact) joint.stop = stop_of(entries, fmt::format("joint.{}", k));
      if (joint.kind == JointKind::spring) joint.stiffness = of_joint("stiffness"), joint.damping = of_joint("damping");
    }
    scene.chain.push_back(std::move(member));
  }
  scene.bar = whole_of(scene.chain);
  const auto take = [&](const char* leaf, SpaceFunction& function, Places& places, SpaceFunction Member::*own) {
    const std::vector<Part> parts = parts_of(entries, scene.chain, leaf, scene.bar.length);
    for (std::size_t m = 0; m < count; ++m) scene.chain[m].*own = parts[m].function;
    function = along(scene.chain, own);
    places = {joined(parts, &Places::breaks, true), joined(parts, &Places::detail, false)};
  };
  take("displacement", scene.displacement, scene.displacement_places, &Member::displacement);
  take("velocity", scene.velocity, scene.velocity_places, &Member::velocity);
  run.bar_meshes = meshes_of(entries, scene.chain);
  std::size_t sum = 0;
  for (const Mesh& own : run.bar_meshes) sum += own.elements;
  bool own = false;
  for (std::size_t k = 1; k <= count; ++k)
    own |= entries.present(key_of("bar", k, "elements")) || entries.present(key_of("bar", k, "nodes"));
  if (!own || !entries.present("mesh.elements")) run.elements = sum;
}

void differentiate_chain(const SceneEntries& entries, const std::string& by, std::size_t longer, Scene& rates) {
  const auto take = [&](const char* leaf, SpaceFunction& function, SpaceFunction Member::*rate) {
    const auto whole = entries.formula(fmt::format("initial.{}", leaf));
    double begin = 0.0;
    for (std::size_t k = 1; k <= rates.chain.size(); ++k) {
      Member& member = rates.chain[k - 1];
      const double length = member.bar.length, from = begin;
      begin += length;
      const auto own = entries.formula(key_of("bar", k, leaf));
      const auto& formula = own ? own : whole;
      const SpaceTimeFunction slope =
          formula ? formula->mean_derivative(by, own ? length : rates.bar.length) : SpaceTimeFunction();
      if (!slope) continue;
      if (longer == 0)
        member.*rate = [slope, at = own ? 0.0 : from](double x) { return slope(at + x, 0.0); };
      else if (k == longer)
        member.*rate = [slope, at = own ? 0.0 : from, length](double x) { return x / length * slope(at + x, 0.0); };
      else if (k > longer && !own)
        member.*rate = [slope, from](double x) { return slope(from + x, 0.0); };
    }
    function = along(rates.chain, rate);
  };
  for (Member& member : rates.chain) member.displacement = member.velocity = [](double) { return 0.0; };
  take("displacement", rates.displacement, &Member::displacement);
  take("velocity", rates.velocity, &Member::velocity);
}

void describe_chain(const SceneEntries& entries, const Case& run, SceneValues& values) {
  for (std::size_t k = 1; k <= run.scene.chain.size(); ++k) {
    for (const SceneKey& row : member_keys()) {
      if (row.table() == "joint" && k == run.scene.chain.size()) continue;
      const std::string key = key_of(row.table(), k, row.leaf());
      if (row.leaf() == "elements") {
        if (!run.scene.chain[k - 1].rigid())
          values.emplace_back(key, static_cast<std::int64_t>(run.bar_meshes[k - 1].elements));
      } else if (entries.present(key)) {
        values.emplace_back(key, entries.described(key));
      }
    }
  }
}

}  // namespace viscobar
