#include "input/scene_stop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

namespace viscobar {

namespace {

enum Leaf { law, stiffness, damping, restitution, speed };
constexpr const char* leaves[] = {"law", "stiffness", "damping", "restitution", "speed"};

// `table` is that of an end or a joint, or empty: [contact] itself.
std::string prefix_of(const std::string& table) {
  return table.empty() ? "contact." : table.starts_with("joint.") ? table + "." : table + ".contact.";
}
std::string key(const std::string& table, Leaf leaf) { return prefix_of(table) + leaves[leaf]; }

std::optional<Law> law_of(const SceneEntries& entries, const std::string& table) {
  const auto word = entries.text(key(table, law));
  const auto* kind = std::ranges::find_if(all_laws, [&](Law one) { return word == name(one); });
  return kind == std::end(all_laws) ? std::nullopt : std::optional(*kind);
}

// lambda with which a lone mass that comes at a speed V leaves at e V: the root a = lambda V < 1 / e of a (1 + e) =
// ln((1 + a) / (1 - a e)), whose right-hand side is the less before it. 0 for e = 1.
double lambda_of(double e, double V) {
  double low = 0.0, high = e < 1.0 ? 1.0 / e : 0.0;
  for (int k = 0; k < 200 && low < high; ++k) {
    const double a = 0.5 * (low + high);
    (std::log1p(a) - std::log1p(-a * e) < a * (1.0 + e) ? low : high) = a;
  }
  return low / V;
}

void check_law(SceneEntries& entries, const std::string& table) {
  const auto of = [&](Leaf leaf) { return key(table, leaf); };
  if (entries.faulty(of(law))) return;
  const auto kind = law_of(entries, table);
  if (!kind) {
    const std::string why = entries.present(of(law)) ? "the law is \"penalty\"" : of(law) + " is missing";
    for (const Leaf leaf : {stiffness, damping, restitution, speed})
      if (entries.sound(of(leaf)) && !(table.empty() && leaf == restitution))
        entries.report(of(leaf), "belongs to a law, and {}; the penalty has contact.epsilon", why);
    return;
  }
  const std::string_view word = name(*kind);
  if (!entries.present(of(stiffness)) && !entries.faulty(of(stiffness)))
    entries.report(of(stiffness), "is missing: {} has a stiffness k", word);
  if (entries.sound(of(damping)) && !has_damper(*kind))
    entries.report(of(damping), "belongs to spring_damper and hunt_crossley; {} has no damper", word);
  if (!entries.sound(of(speed))) {
    if (!table.empty() && entries.sound(of(restitution)))
      entries.report(of(restitution), "is that at a speed of impact, and {} is missing", of(speed));
    return;
  }
  if (*kind != Law::hunt_crossley)
    entries.report(of(speed), "belongs to hunt_crossley, whose restitution depends on it; {} has a damping", word);
  else if (entries.present(of(damping)))
    entries.report(of(speed), "excludes {}: lambda is one or the other", of(damping));
  else if (!entries.present(of(restitution)))
    entries.report(of(restitution), "is missing: of an impact at {}", of(speed));
  else if (entries.number(of(restitution)) == 0.0)
    entries.report(of(restitution), "must be positive: hunt_crossley throws back whatever its lambda");
}

}  // namespace

std::optional<Stop> stop_of(const SceneEntries& entries, const std::string& side) {
  const bool of_joint = side.starts_with("joint.");
  const bool own = of_joint ? entries.present(key(side, law)) : entries.given_below(prefix_of(side));
  const std::string table = own ? side : "";
  const auto kind = law_of(entries, table);
  if (!kind) return std::nullopt;
  const auto number = [&](Leaf leaf) { return entries.number(key(table, leaf)); };
  const auto e = number(restitution), at = number(speed);
  const double damped = *kind == Law::hunt_crossley && e > 0.0 && at ? lambda_of(*e, *at) : 0.0;
  return Stop{*kind, number(stiffness).value_or(1.0), number(damping).value_or(damped), !own};
}

std::optional<std::pair<std::string, double>> damping_by(const SceneEntries& entries, const std::string& of) {
  for (const char* table : {"", "left", "right"}) {
    const auto e = entries.number(key(table, restitution)), V = entries.number(key(table, speed));
    if (!e || !V) continue;
    if (of == key(table, damping))
      throw std::invalid_argument(
          fmt::format("{}: no sensitivity with respect to it: the scene has {} and {} in its "
                      "place; take one of these",
                      of, key(table, restitution), key(table, speed)));
    const double a = *V * lambda_of(*e, *V);
    if (of == key(table, speed)) return std::pair(key(table, damping), -a / (*V * *V));
    // By the derivative of that equation; a = 3 (1 - e) / 2 near e = 1.
    const double slope = *e < 1.0 ? -a * *e * (1.0 + a) / ((1.0 + *e) * (a * *e - (1.0 - *e))) : -1.5;
    if (of == key(table, restitution)) return std::pair(key(table, damping), slope / *V);
  }
  return std::nullopt;
}

void check_laws(SceneEntries& entries) {
  for (const auto& [prefix, table] :
       {std::pair{"contact.", ""}, {"left.contact.", "left"}, {"right.contact.", "right"}})
    if (entries.given_below(prefix)) check_law(entries, table);
  for (std::size_t k = 1; k <= entries.members("joint"); ++k)
    if (const std::string joint = fmt::format("joint.{}", k); entries.text(joint + ".kind") == "contact")
      check_law(entries, joint);
}

}  // namespace viscobar
