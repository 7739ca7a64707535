#include <fmt/format.h>

#include <array>

#include "report/compare/compare_tables.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar {

std::string trial_text(const TrialResult& result) {
  const NumberText number = NumberText::terminal(result.check.runs.front().setup.run.scene);
  std::string out =
      fmt::format("{}: {} against its references, largest over time\n", result.name, result.scheme().label) +
      text(difference_table(result.check, number, "reference", [&](std::size_t i) { return result.to(i); })) +
      contact_text(result.check, number);
  for (const Finding& finding : result.findings) out += fmt::format("  {}: {}\n", finding.key, finding.problem);
  return out;
}

std::string order_text(const OrderStudy& study) {
  const NumberText number = NumberText::terminal();
  Table table{
      {"elements", "step", "u, L2", "order", "end trace", "order", "v, L2", "order", "reaction, L1", "order"}, 0, {}};
  const std::array quantities = {&exact::Error::displacement_l2, &exact::Error::end_trace, &exact::Error::velocity_l2,
                                 &exact::Error::reaction_l1};
  for (std::size_t i = 0; i < study.rows.size(); ++i) {
    const OrderStudy::Row& row = study.rows[i];
    std::vector<std::string> cells = {fmt::format("{}", row.elements), row.step ? number(*row.step) : "-"};
    for (const auto quantity : quantities) {
      const auto power = i > 0 ? study.errors(quantity).power(i - 1) : std::nullopt;
      cells.push_back(number(row.error.*quantity));
      cells.push_back(power ? fmt::format("{:.2f}", *power) : "-");
    }
    table.rows.push_back(std::move(cells));
  }
  std::string out = text(table);
  const auto tell = [&](const char* quantity, const std::optional<SequenceOrder>& order) {
    out += fmt::format("  order of {}: {}\n", quantity,
                       order ? fmt::format("{:.2f} +- {:.2f}", order->order, order->bound) : "not settled");
  };
  tell("u in L2", study.displacement_l2);
  tell("the end traces", study.end_trace);
  if (study.errors(&exact::Error::velocity_l2).last_told()) tell("v in L2", study.velocity_l2);
  if (study.errors(&exact::Error::reaction_l1).last_told()) tell("the reactions in L1", study.reaction_l1);
  return out;
}

}  // namespace viscobar
