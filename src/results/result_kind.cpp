#include "results/result_kind.hpp"

namespace viscobar {

std::span<const ResultFiles> result_kinds() {
  static constexpr ResultFiles kinds[] = {
      {"run", "summary.json", "summary.json",
       "ends.csv events.csv energy.csv sensitivity.csv gauges.csv joints.csv field.h5 field.xdmf report.html "
       "checkpoint.bin checkpoint.previous.bin",
       R"("versions" "viscobar" "method")",
       "title method elements=/scene/mesh/elements mass epsilon=/scene/contact/epsilon completed error reached_time "
       "end_time=/scene/time/end output_every=/scene/output/every steps contact_changes=/events "
       "largest_penetration=/max_penetration energy_initial=/energy/initial energy_final=/energy/final "
       "energy_balance_error=/energy/balance_error integration_seconds wall_seconds version=/versions/viscobar"},
      {"compare", "compare.json", "compare.json", "compare.html compare.csv", R"("pairs" "version")",
       "title methods=/methods/*/method reference completed left_out=/skipped/# "
       "nearest_to_reference=/pairs/<end_trace/other its_end_difference=/pairs/<end_trace/end_trace version"},
      {"limit", "limit.json", "limit.json", "limit.html limit.csv", R"("verdict" "version")",
       "title mass elements=/rows/*/elements rows=/rows/# completed verdict reason order_penetration order_to_rigid "
       "order_to_scheme version"},
      {"precision", "precision.json", "precision.json", "precision.html precision.csv", R"("reference" "version")",
       "title methods=/rows/*/method elements=/rows/*/elements rows=/rows/# completed reference=/reference/description "
       "reference_error=/reference/error smallest_error=/rows/<error/error by=/rows/<error/method "
       "with=/rows/<error/label in_seconds=/rows/<error/seconds version"},
      {"sweep", "sweep.h5", "sweep.json", "sweep.csv timings.csv sweep.json sweep.html", "viscobar \x89HDF",
       "title keys failed=/failed/# integration_seconds wall_seconds"},
      {"fit", "fit.json", "fit.json", "fit.html", R"("covariance" "version")",
       "title parameters=/parameters/@ measured converged runs residual version"},
      {"judge", "judge.json", "judge.json", "judge.html", R"("judged" "version")",
       "title judged=/judged/*/label missed=/judged/*/missed made_up=/judged/*/made_up version"}};
  return kinds;
}

}  // namespace viscobar
