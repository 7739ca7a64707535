#include <fmt/format.h>

#include <cmath>

#include "report/compare/compare_tables.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar {

std::string trial_text(const TrialResult& result) {
  std::string out =
      fmt::format("{}: {} against its references, largest over time\n", result.name, result.scheme().label) +
      text(difference_table(result.check, plain_number, "reference", [&](std::size_t i) { return result.to(i); })) +
      contact_text(result.check);
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
