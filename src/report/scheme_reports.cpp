#include <fmt/format.h>

#include <cmath>

#include "report/compare/compare_tables.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar {

namespace {

Table differences(const TrialResult& result) {
  Table table{{"reference", "u, L2", "u, H1", "v, L2", "end trace", "changes matched", "largest shift"}, 1, {}};
  const auto known = [](const std::optional<double>& value) { return value ? plain_number(*value) : std::string("-"); };
  for (std::size_t i = 0; i + 1 < result.check.runs.size(); ++i) {
    const Difference* d = result.to(i);
    if (!d) continue;
    table.rows.push_back({result.check.runs[i].label, known(d->displacement_l2), known(d->displacement_h1),
                          known(d->velocity_l2), plain_number(d->end_trace),
                          fmt::format("{} of {}, {}", d->events_matched, d->events, d->events_other),
                          known(d->largest_event_shift)});
  }
  return table;
}

}  // namespace

std::string trial_text(const TrialResult& result) {
  std::string out =
      fmt::format("{}: {} against its references, largest over time\n", result.name, result.scheme().label) +
      text(differences(result));
  if (const Table contacts = contact_table(result.check, plain_number); !contacts.rows.empty())
    out += "\nContact periods, bounces within a hundredth of the run counted as one\n" + text(contacts);
  for (const Finding& finding : result.findings) out += fmt::format("  {}: {}\n", finding.key, finding.problem);
  return out;
}

std::string order_text(const OrderStudy& study) {
  Table table{
      {"elements", "step", "u, L2", "order", "end trace", "order", "v, L2", "order", "reaction, L1", "order"}, 0, {}};
  const OrderStudy::Row* before = nullptr;
  for (const OrderStudy::Row& row : study.rows) {
    std::vector<std::string> cells = {fmt::format("{}", row.elements), row.step ? plain_number(*row.step) : "-"};
    for (const auto quantity : {&exact::Error::displacement_l2, &exact::Error::end_trace, &exact::Error::velocity_l2,
                                &exact::Error::reaction_l1}) {
      const double value = row.error.*quantity;
      cells.push_back(plain_number(value));
      cells.push_back(before && value > 0.0 ? fmt::format("{:.2f}", std::log2(before->error.*quantity / value)) : "-");
    }
    table.rows.push_back(std::move(cells));
    before = &row;
  }
  std::string out = text(table);
  const auto fit = [&](const char* quantity, const std::optional<ObservedOrder>& order) {
    if (order) out += fmt::format("  order of {}: {:.2f} +- {:.2f}\n", quantity, order->order, order->standard_error);
  };
  fit("u in L2", study.displacement_l2);
  fit("the end traces", study.end_trace);
  fit("v in L2", study.velocity_l2);
  fit("the reactions in L1", study.reaction_l1);
  return out;
}

}  // namespace viscobar
