#include "report/limit/limit_tables.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "case/massless.hpp"

namespace viscobar {

namespace {

std::string with_error(const std::optional<SequenceOrder>& order) {
  return order ? fmt::format("{:.3f} +- {:.3f}", order->order, order->bound) : "not settled";
}

std::string power(std::optional<double> value) {
  if (!value) return "none";
  if (*value == 0.5) return "1/2";
  return *value == 1.0 ? "1" : "2/3";
}

}  // namespace

std::span<const LimitRow> rows_of(const LimitResult& result, std::size_t mesh) {
  const LimitOrders& orders = result.orders[mesh];
  return std::span(result.rows).subspan(orders.first_row, orders.row_count);
}

std::size_t finest(const LimitResult& result) {
  const auto found = std::ranges::max_element(result.orders, {}, &LimitOrders::elements);
  return static_cast<std::size_t>(found - result.orders.begin());
}

LimitTheory theory(const LimitStudy& study) {
  if (are_massless(study.scene.scene, common_mass(study.scene))) return {1.0, 1.0};
  const bool common = study.scene.restitution.has_value();
  if (!study.scene.scene.span) return {0.5, common ? std::optional(0.5) : std::nullopt};
  // Contacts of neighbours are one impact each only where the mass does not couple them.
  const bool apart = resolve(study.scene).mass != Mass::consistent;
  return {0.5, common && apart ? std::optional(0.5) : std::nullopt, std::nullopt, "ρh⁴/η²"};
}

namespace {

std::string within(const char* of, const std::optional<double>& error, const NumberText& number) {
  return error ? fmt::format("{} is {} away at most", of, number(*error, Dimension::length, 2))
               : fmt::format("{} does not settle", of);
}

std::string undecided_reason(const LimitStudy& study, const LimitOrders& orders, std::span<const LimitRow> rows,
                             const NumberText& number) {
  const auto length = [&](double value, int digits = 2) { return number(value, Dimension::length, digits); };
  const auto penalty = [&](double epsilon) { return number(epsilon, number.of_epsilon, 2); };
  const LimitEvidence& evidence = orders.evidence;
  std::string budget;
  if (orders.interrupted)
    budget = ". The study was interrupted";
  else if (orders.lacking_seconds)
    budget = fmt::format(". The next run takes about {:.2g} s of the processor, and --budget {:.3g} does not allow it",
                         *orders.lacking_seconds, study.budget);
  else if (study.budget == 0.0)
    budget = ". --budget 0 allows no run beyond those asked for";
  if (rows.empty() || orders.scheme.empty())
    return fmt::format(
        "no run of the {} came to its end, so there is nothing to compare{}. A larger --budget would tell",
        rows.empty() ? "penalised bar" : "scheme", budget);
  const LimitRow& last = rows.back();
  const std::string found =
      fmt::format("the difference to the scheme is {} at epsilon = {} and dt = {}", length(evidence.difference),
                  penalty(last.epsilon), number(orders.scheme_step, Dimension::time, 2));
  const std::string limits = evidence.apart ? fmt::format(". The limits differ by {} +- {}", length(*evidence.apart),
                                                          length(evidence.apart_error, 1))
                                            : "";
  const std::string known =
      found + limits + "; " + within("the limit of the penalised bar", evidence.penalty_error, number) + ", " +
      within("that of the scheme", evidence.scheme_error, number) +
      (evidence.stake
           ? fmt::format("; {} changes {}, beside which all of this must be small",
                         evidence.by_law ? "another law of impact" : "contact itself", length(*evidence.stake))
           : std::string());
  switch (evidence.missing) {
    case Missing::obstacle:
      return fmt::format(
          "the bar goes {} deep into the obstacle at epsilon = {}, a tenth or more of its displacement: so "
          "soft a penalty is no obstacle{}. Smaller epsilons would decide it: leave --epsilon out",
          length(last.max_penetration), penalty(last.epsilon), budget);
    case Missing::contact:
      return fmt::format(
          "nothing touches an obstacle at epsilon = {}, so there is no contact to compare; {}. A smaller gap, a "
          "longer run or a throw towards the obstacle would decide it",
          penalty(last.epsilon), found);
    case Missing::penalties:
      return found +
             ". Whether the penalised bar settles takes three epsilons or more to say: a longer --epsilon range would "
             "decide it";
    case Missing::smaller_epsilon: return fmt::format("{}. A smaller epsilon would decide it{}", known, budget);
    case Missing::larger_epsilon:
      return fmt::format(
          "{}; the penalised bar changes the more from one epsilon to the next, the smaller they are. That is the "
          "error of the time integration at so stiff a penalty, or contact that magnifies it. A range that ends at a "
          "larger epsilon, method.name = \"exponential\" or a shorter time.end would decide it",
          found);
    case Missing::tighter_tolerance:
      return fmt::format("{}. Tighter tolerances than {:.1g} would decide it{}", known, orders.tolerance, budget);
    case Missing::smaller_step:
    case Missing::runs:
    case Missing::nothing: break;
  }
  std::string text = fmt::format("{}. A smaller step would decide it{}", known, budget);
  if (!evidence.scheme_error && orders.scheme.size() > 4)
    text += ". If the scheme does not settle there either, contact magnifies its errors: a shorter time.end would tell";
  return text;
}

std::string remedy_of_plateau(const LimitStudy& study) {
  if (are_massless(study.scene.scene, common_mass(study.scene))) return "";
  if (!study.scene.restitution)
    return std::string(
               ". A contact node with mass rebounds from an undamped penalty and not from the scheme's constraint: "
               "contact.restitution gives both the same law") +
           (!may_be_massless(study.scene) ? "" : ", --mass redistributed takes the mass away");
  if (study.scene.scene.span && resolve(study.scene).mass == Mass::consistent)
    return ". Under a span obstacle the consistent mass ties the impacts of neighbours together, where penalty and "
           "scheme share no law; with --mass lumped they do";
  return "";
}

}  // namespace

std::string limit_sentence(const LimitOrders& orders, const NumberText& number) {
  const LimitEvidence& evidence = orders.evidence;
  const auto lower = evidence.lower(), upper = evidence.upper();
  if (orders.verdict == Verdict::undecided || !upper || orders.largest == 0.0) return "";
  const std::string mesh = fmt::format("at {} elements", orders.elements);
  const auto share = [&](double value) {
    return fmt::format("{} % of the largest displacement", number(100.0 * value / orders.largest, 2));
  };
  if (orders.verdict == Verdict::converges)
    return fmt::format("{} the limits agree to {} ({})", mesh, number(*upper, Dimension::length, 1), share(*upper));
  if (evidence.apart && !evidence.until)
    return fmt::format("{} the limits differ by {} +- {} ({})", mesh, number(*evidence.apart, Dimension::length),
                       number(evidence.apart_error, Dimension::length, 1), share(*evidence.apart));
  return fmt::format("{} the limits differ by {} or more ({})", mesh, number(*lower, Dimension::length, 2),
                     share(*lower));
}

std::string verdict_reason(const LimitStudy& study, const LimitResult& result, std::size_t mesh,
                           const NumberText& number) {
  const LimitOrders& orders = result.orders[mesh];
  const auto rows = rows_of(result, mesh);
  const LimitEvidence& evidence = orders.evidence;
  if (orders.verdict == Verdict::undecided) return undecided_reason(study, orders, rows, number);
  std::string reason = limit_sentence(orders, number);
  const auto length = [&](double value) { return number(value, Dimension::length, 2); };
  const auto penalty = [&](const LimitRow& row) { return number(row.epsilon, number.of_epsilon, 2); };
  if (evidence.until)
    reason += orders.verdict == Verdict::plateau
                  ? fmt::format(", already up to t = {}", number(*evidence.until, Dimension::time))
                  : fmt::format(
                        "; both sequences are seen to tend to one limit up to t = {}, behind which the bar "
                        "magnifies what is left of them",
                        number(*evidence.until, Dimension::time));
  if (!rows.empty() && !evidence.until) {
    const LimitRow &first = rows.front(), &last = rows.back();
    reason += fmt::format(
        "; the difference to the scheme {} {} at epsilon = {}, of which epsilon makes {} at most and the scheme makes {} by "
        "its step {}{}",
        orders.verdict == Verdict::plateau
            ? "stays near"
            : fmt::format("goes from {} at epsilon = {} to", length(first.difference_to_scheme), penalty(first)),
        length(evidence.difference), penalty(last), length(evidence.penalty_error.value_or(0.0)),
        length(evidence.scheme_error.value_or(0.0)), number(orders.scheme_step, Dimension::time, 2),
        evidence.extrapolated ? ", extrapolated" : "");
    if (orders.verdict == Verdict::plateau)
      reason += fmt::format("; contact changes go from {} to {}, the scheme has {}", first.events, last.events,
                            orders.scheme_events);
    if (evidence.stake)
      reason +=
          fmt::format("; {} the motion would differ by {}",
                      evidence.by_law ? "with another law of impact" : "without contact", length(*evidence.stake));
  }
  const auto finer = [&](const LimitOrders& other) {
    return other.verdict == Verdict::plateau && other.elements > orders.elements;
  };
  const bool tells = orders.verdict == Verdict::plateau && std::ranges::none_of(result.orders, finer);
  return tells ? reason + remedy_of_plateau(study) : reason;
}

const std::vector<Column<LimitRow>>& limit_columns() {
  static const std::vector<Column<LimitRow>> columns = {
      column("epsilon", "epsilon", &LimitRow::epsilon),
      column("elements", "elements", &LimitRow::elements),
      {"mass", "mass", [](const LimitRow& row) { return cell(name(row.mass)); }},
      column("events", "contact changes", &LimitRow::events),
      column("max_penetration", "largest penetration", &LimitRow::max_penetration).in(Dimension::length),
      column("difference_to_scheme", "to the scheme", &LimitRow::difference_to_scheme).in(Dimension::length),
      column("difference_to_rigid", "", &LimitRow::difference_to_scheme_limit, true),  // its name for scripts
      column("difference_to_own_limit", "to its own limit", &LimitRow::difference_to_own_limit, true)
          .in(Dimension::length),
      column("difference_to_scheme_limit", "to the scheme's limit", &LimitRow::difference_to_scheme_limit, true)
          .in(Dimension::length),
      column("tolerance", "tolerance", &LimitRow::tolerance),
      column("steps", "steps", &LimitRow::steps),
      column("seconds", "seconds", &LimitRow::seconds)};
  return columns;
}

namespace {

/// The unit of epsilon is the scene's: it has one more length under the span.
template <class Row>
std::vector<Column<Row>> with_unit_of_epsilon(std::vector<Column<Row>> columns, const NumberText& number) {
  std::ranges::find(columns, "epsilon", &Column<Row>::key)->unit = number.of_epsilon;
  return columns;
}

}  // namespace

Table limit_table(const LimitResult& result, const NumberText& number) {
  return table_of(with_unit_of_epsilon(pick(limit_columns(), {"elements", "epsilon", "events", "max_penetration",
                                                              "difference_to_scheme", "difference_to_own_limit",
                                                              "difference_to_scheme_limit", "steps", "seconds"}),
                                       number),
                  result.rows, number, 0);
}

Table order_table(const LimitStudy& study, const LimitResult& result, const NumberText& number) {
  const LimitTheory powers = theory(study);
  Table table{{"elements", "regime", "penetration", "theory", "to its own limit", "theory", "to the scheme", "theory",
               "scheme's power of dt"},
              2,
              {}};
  for (const LimitOrders& o : result.orders) {
    const std::string boundary = o.boundary ? number(*o.boundary, number.of_epsilon, 2) : "";
    const bool plateau = o.verdict == Verdict::plateau;
    table.rows.push_back(
        {fmt::format("{}", o.elements), o.boundary ? "small epsilon, below " + boundary : "every epsilon",
         with_error(o.penetration), power(powers.penetration), with_error(o.to_own_limit), power(powers.penetration),
         plateau ? "a plateau" : with_error(o.to_scheme), power(powers.difference), with_error(o.of_step)});
    if (!o.penetration_layer && !o.to_scheme_limit_layer) continue;
    table.rows.push_back({fmt::format("{}", o.elements), "layer resolved, above " + boundary,
                          with_error(o.penetration_layer), power(powers.layer), with_error(o.to_scheme_limit_layer),
                          power(powers.layer), "-", "-", "-"});
  }
  return table;
}

const std::vector<Column<OwnMotion::Mesh>>& own_motion_columns() {
  using Row = OwnMotion::Mesh;
  static const std::vector<Column<Row>> columns = {
      column("elements", "elements", &Row::elements),
      column("spacing", "h", &Row::spacing).in(Dimension::length),
      column("penalty", "penalty's limit to the bar", &Row::penalty).in(Dimension::length),
      column("scheme", "scheme's limit to the bar", &Row::scheme).in(Dimension::length),
      column("apart", "limits apart", &Row::apart).in(Dimension::length),
      column("epsilon", "epsilon(h)", &Row::epsilon).or_else("outside"),
      column("step", "dt(h)", &Row::step).or_else("outside").in(Dimension::time)};
  return columns;
}

Table own_motion_table(const OwnMotion& motion, const NumberText& number) {
  return table_of(with_unit_of_epsilon(own_motion_columns(), number), motion.meshes, number, 0);
}

std::string own_motion_sentence(const OwnMotion& motion, const NumberText& number) {
  const auto like = [](const std::optional<SequenceOrder>& order) {
    return order ? fmt::format("like h^{:.2f} (+- {:.2f})", order->order, order->bound)
                 : "by a power that is not settled";
  };
  std::string sentence = fmt::format("The penalised bar's limit tends to the bar's own motion {}, the scheme's {}",
                                     like(motion.penalty), like(motion.scheme));
  if (std::ranges::any_of(motion.meshes, [](const OwnMotion::Mesh& mesh) { return mesh.apart > 0.0; }))
    sentence += fmt::format("; the difference of the limits falls {}", like(motion.apart));
  return sentence + fmt::format(
                        ". The bar's own motion is that of {}, known to {}; at epsilon(h) and dt(h) penalty "
                        "and step cost as much as the mesh.",
                        motion.reference, number(motion.error, Dimension::length, 1));
}

const std::vector<Column<Coupling::Mesh>>& coupling_columns() {
  using Row = Coupling::Mesh;
  const auto order = [](const Row& mesh) { return mesh.epsilon ? Cell(mesh.local_order) : Cell(); };
  static const std::vector<Column<Row>> columns = {
      column("elements", "elements", &Row::elements), column("spacing", "h", &Row::spacing).in(Dimension::length),
      column("mesh_error", "error of the mesh", &Row::mesh_error).in(Dimension::length),
      column("epsilon", "epsilon(h)", &Row::epsilon).or_else("outside"),
      Column<Row>{"local_order", "local power of epsilon", order}.or_else("-")};
  return columns;
}

Table coupling_table(const Coupling& coupling, const NumberText& number) {
  return table_of(with_unit_of_epsilon(coupling_columns(), number), coupling.meshes, number, 0);
}

std::string coupling_sentence(const CouplingResult& result, const NumberText& number) {
  if (!result.coupling) return "No epsilon(h) is given: " + result.reason + ".";
  const Coupling& c = *result.coupling;
  std::string sentence = fmt::format("The {} end traces converge like h^{:.2f}", c.limit, c.mesh_order);
  if (c.law)
    sentence +=
        fmt::format("; the penalty costs as much as the mesh where epsilon is of the order h^{:.2f}", c.law->order);
  for (const Coupling::Mesh& mesh : c.meshes)
    if (mesh.epsilon)
      sentence += fmt::format(", epsilon = {} on {} elements", number(*mesh.epsilon, number.of_epsilon), mesh.elements);
  return sentence + ".";
}

}  // namespace viscobar
