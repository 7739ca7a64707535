#include "report/limit/limit_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace viscobar {

namespace {

std::string with_error(const std::optional<ObservedOrder>& order) {
  if (!order) return "-";
  // Two points have no scatter to tell an error from.
  if (order->standard_error == 0.0) return fmt::format("{:.3f}", order->order);
  return fmt::format("{:.3f} +- {:.3f}", order->order, order->standard_error);
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
  if (common_mass(study.scene) == Mass::redistributed) return {1.0, 1.0};
  const bool common = study.scene.restitution.has_value();
  if (!study.scene.scene.span) return {0.5, common ? std::optional(0.5) : std::nullopt};
  // Contacts of neighbours are one impact each only where the mass does not couple them.
  const bool apart = effective_mass(study.scene) != Mass::consistent;
  return {0.5, common && apart ? std::optional(0.5) : std::nullopt, std::nullopt, "ρh⁴/η²"};
}

namespace {

// What would make an undecided verdict a verdict.
std::string undecided_reason(const LimitStudy& study, const LimitOrders& orders, const LimitRow& last) {
  const LimitEvidence& evidence = orders.evidence;
  const std::string found = fmt::format("the difference to the scheme is {:.2g} at epsilon = {:.2g} and dt = {:.2g}",
                                        evidence.difference, last.epsilon, orders.scheme_step);
  const auto within = [](const char* of, const std::optional<double>& error) {
    return error ? fmt::format("{} is known to {:.2g}", of, *error) : fmt::format("{} does not settle", of);
  };
  const std::string penalised = within("the limit of the penalised bar", evidence.penalty_error);
  switch (evidence.lack) {
    case Lack::obstacle:
      return fmt::format(
          "the bar goes {:.2g} deep into the obstacle at epsilon = {:.2g}, a tenth or more of its displacement: so "
          "soft a penalty is no obstacle. Smaller epsilons would decide it: leave --epsilon out",
          last.max_penetration, last.epsilon);
    case Lack::contact:
      return fmt::format(
          "nothing touches an obstacle at epsilon = {:.2g}, so there is no contact to compare; {}. A smaller gap, a "
          "longer run or a throw towards the obstacle would decide it",
          last.epsilon, found);
    case Lack::penalties:
      return found +
             ". Whether the penalised bar settles takes three epsilons or more to say: a longer --epsilon range would "
             "decide it";
    case Lack::smaller_epsilon:
      return fmt::format("{}; {}. A smaller epsilon would decide it: --epsilon {:.0e}:{:.0e}, say", found, penalised,
                         study.epsilons.front(), 0.01 * last.epsilon);
    case Lack::larger_epsilon:
      return fmt::format(
          "{}; the penalised bar changes the more from one epsilon to the next, the smaller they are. That is the "
          "error of the time integration at so stiff a penalty, or contact that magnifies it. A range that ends at a "
          "larger epsilon, method.name = \"exponential\" or a shorter time.end would decide it",
          found);
    case Lack::smaller_step: break;
    case Lack::nothing: return found;
  }
  const double next = orders.scheme.back().seconds * orders.scheme[orders.scheme.size() - 2].step / orders.scheme_step;
  std::string text = fmt::format(
      "{}; {}, {}. A smaller step would decide it: the next one takes about {:.2g} s of the processor, --budget is "
      "{:.3g}",
      found, penalised, within("that of the scheme", evidence.scheme_error), next, study.budget);
  if (!evidence.scheme_error && orders.scheme.size() > 4)
    text += ". If the scheme does not settle there either, contact magnifies its errors: a shorter time.end would tell";
  return text;
}

}  // namespace

std::string verdict_reason(const LimitStudy& study, const LimitOrders& orders, std::span<const LimitRow> rows) {
  const LimitRow &first = rows.front(), &last = rows.back();
  const LimitEvidence& evidence = orders.evidence;
  if (orders.verdict == Verdict::undecided) return undecided_reason(study, orders, last);
  const std::string errors =
      fmt::format("{:.2g} of it at most is that of epsilon, {:.2g} that of the scheme's step {:.2g}{}",
                  evidence.penalty_error.value_or(0.0), evidence.scheme_error.value_or(0.0), orders.scheme_step,
                  evidence.extrapolated ? ", extrapolated" : "");
  if (orders.verdict == Verdict::plateau) {
    std::string text = fmt::format(
        "the difference to the scheme stays near {:.2g} at epsilon = {:.2g}, and {}: the limits are {:.2g} apart or "
        "more; contact changes go from {} to {}, the scheme has {}",
        evidence.difference, last.epsilon, errors, evidence.lower().value_or(0.0), first.events, last.events,
        orders.scheme_events);
    if (common_mass(study.scene) == Mass::redistributed) return text;
    if (!study.scene.restitution)
      return text +
             ". A contact node with mass rebounds from an undamped penalty and not from the scheme's constraint: "
             "contact.restitution gives both the same law" +
             (study.scene.scene.span ? "" : ", --mass redistributed takes the mass away");
    if (study.scene.scene.span && effective_mass(study.scene) == Mass::consistent)
      return text +
             ". Under a span obstacle the consistent mass ties the impacts of neighbours together, where penalty and "
             "scheme share no law; with --mass lumped they do";
    return text;
  }
  return fmt::format(
      "the difference to the scheme goes from {:.2g} at epsilon = {:.2g} to {:.2g} at {:.2g}, and {}: the limits agree "
      "to {:.2g}, where {} puts {:.2g} at stake",
      first.difference_to_scheme, first.epsilon, evidence.difference, last.epsilon, errors,
      evidence.upper().value_or(0.0), evidence.by_law ? "another law of impact" : "contact itself",
      evidence.stake.value_or(0.0));
}

Table limit_table(const LimitResult& result, NumberText number) {
  const bool rigid =
      std::ranges::any_of(result.rows, [](const LimitRow& row) { return row.difference_to_rigid.has_value(); });
  Table table{{"elements", "epsilon", "contact changes", "largest penetration", "to the scheme"}, 0, {}};
  if (rigid) table.header.emplace_back("to the rigid limit");
  table.header.insert(table.header.end(), {"steps", "seconds"});
  for (const LimitRow& row : result.rows) {
    std::vector<std::string> cells = {fmt::format("{}", row.elements), number(row.epsilon),
                                      fmt::format("{}", row.events), number(row.max_penetration),
                                      number(row.difference_to_scheme)};
    if (rigid) cells.push_back(row.difference_to_rigid ? number(*row.difference_to_rigid) : "");
    cells.insert(cells.end(), {fmt::format("{}", row.steps), number(row.seconds)});
    table.rows.push_back(std::move(cells));
  }
  return table;
}

Table order_table(const LimitStudy& study, const LimitResult& result) {
  const LimitTheory powers = theory(study);
  const bool rigid = common_mass(study.scene) == Mass::redistributed;
  Table table{{"elements", "regime", "penetration", "theory", "to the scheme", "theory"}, 2, {}};
  if (rigid) table.header.insert(table.header.end(), {"to the rigid limit", "theory"});
  for (std::size_t m = 0; m < result.orders.size(); ++m) {
    const LimitOrders& o = result.orders[m];
    const auto rows = rows_of(result, m);
    const auto below = std::count_if(rows.begin(), rows.end(), [&](const LimitRow& row) {
      return !o.boundary || row.epsilon <= 0.01 * *o.boundary;
    });
    const bool mixed = o.boundary && below < 2;
    const std::string difference = mixed ? "-" : power(powers.difference), layer = power(powers.layer);
    const auto add = [&](const std::string& regime, std::vector<std::string> cells) {
      cells.insert(cells.begin(), {fmt::format("{}", o.elements), regime});
      cells.resize(table.header.size());  // without the rigid limit
      table.rows.push_back(std::move(cells));
    };
    add(!o.boundary ? "every epsilon"
        : mixed     ? "every epsilon, regimes mixed"
                    : fmt::format("epsilon < {:.2g}", 0.01 * *o.boundary),
        {with_error(o.penetration), mixed ? "-" : power(powers.penetration), with_error(o.to_scheme), difference,
         with_error(o.to_rigid), difference});
    if (o.penetration_layer)
      add(fmt::format("epsilon > {:.2g}, layer resolved", 100.0 * *o.boundary),
          {with_error(o.penetration_layer), layer, "-", "-", with_error(o.to_rigid_layer), layer});
  }
  return table;
}

Table local_power_table(const LimitResult& result, NumberText number) {
  Table table{{"elements", "epsilon", "difference to", "largest", "power here", "to the next", "mean square",
               "power here", "to the next"},
              0,
              {}};
  const auto power = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.4f}", *value) : std::string("-");
  };
  for (std::size_t m = 0; m < result.orders.size(); ++m) {
    const auto rows = rows_of(result, m);
    for (const LimitRow& row : rows) {
      std::vector<std::string> cells = {
          fmt::format("{}", row.elements), number(row.epsilon),
          result.orders[m].local_to_rigid ? std::string("rigid") : number(rows.back().epsilon)};
      for (const auto& local : {row.local_largest, row.local_mean}) {
        const LocalPower known = local.value_or(LocalPower{});
        cells.push_back(local ? number(known.difference) : std::string("-"));
        cells.push_back(power(known.power));
        cells.push_back(power(known.observed));
      }
      table.rows.push_back(std::move(cells));
    }
  }
  return table;
}

std::vector<std::string> local_power_remarks(const LimitResult& result) {
  std::vector<std::string> remarks;
  for (std::size_t i = 0; i + 1 < result.rows.size(); ++i) {
    const LimitRow& row = result.rows[i];
    const auto tell = [&](const std::optional<LocalPower>& local, const char* norm) {
      if (!local || local->agrees().value_or(true)) return;
      remarks.push_back(fmt::format(
          "Between epsilon = {:.2g} and {:.2g} on {} elements the power of the {} difference is not what its ends say: "
          "{:.3g} is observed, {:.3g} the mean of the derivatives, and they would be {:.2g} apart at most if it changed no "
          "faster there than from row to row. More epsilons (--per-decade) would show it.",
          row.epsilon, result.rows[i + 1].epsilon, row.elements, norm, *local->observed, *local->mean, local->bound));
    };
    tell(row.local_largest, "largest");
    tell(row.local_mean, "mean square");
  }
  return remarks;
}

Table coupling_table(const Coupling& coupling, NumberText number) {
  Table table{{"elements", "h", "error of the mesh", "epsilon(h)", "local power of epsilon"}, 0, {}};
  for (const Coupling::Mesh& mesh : coupling.meshes)
    table.rows.push_back({fmt::format("{}", mesh.elements), number(mesh.spacing), number(mesh.mesh_error),
                          mesh.epsilon ? number(*mesh.epsilon) : "outside",
                          mesh.epsilon ? fmt::format("{:.2f}", mesh.local_order) : "-"});
  return table;
}

std::string coupling_sentence(const CouplingResult& result, NumberText number) {
  if (!result.coupling) return "No epsilon(h) is given: " + result.reason + ".";
  const Coupling& c = *result.coupling;
  std::string sentence = fmt::format("The {} end traces converge like h^{:.2f}", c.limit, c.mesh_order);
  if (c.law)
    sentence +=
        fmt::format("; the penalty costs as much as the mesh where epsilon is of the order h^{:.2f}", c.law->order);
  for (const Coupling::Mesh& mesh : c.meshes)
    if (mesh.epsilon) sentence += fmt::format(", epsilon = {} on {} elements", number(*mesh.epsilon), mesh.elements);
  return sentence + ".";
}

}  // namespace viscobar
