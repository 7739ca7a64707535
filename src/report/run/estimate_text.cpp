#include "report/run/estimate_text.hpp"

#include <fmt/format.h>

#include "report/page.hpp"
#include "text/number.hpp"
#include "text/printable_text.hpp"

namespace viscobar {

namespace {

std::string_view of_words(Goal goal) {
  switch (goal) {
    case Goal::displacement: return "of displacements";
    case Goal::end_traces: return "of the ends' displacements";
    case Goal::contact_times: return "of contact times";
    case Goal::impulse: return "of impulses";
    case Goal::peak_reaction: return "of peak reactions";
  }
  return {};
}

std::string verdict(const ErrorEstimate& estimate) {
  if (!estimate.requested) return "";
  return fmt::format("; {:.2g} asked for: {}", *estimate.requested, estimate.kept ? "kept" : "not kept");
}

}  // namespace

std::vector<std::pair<std::string, std::string>> estimate_rows(const ErrorEstimate& estimate) {
  std::vector<std::pair<std::string, std::string>> rows;
  rows.emplace_back("error, estimated", fmt::format("{:.2g} {} (space {:.2g}, penalty {:.2g}, time {:.2g}){}",
                                                    estimate.total, of_words(estimate.of), estimate.space,
                                                    estimate.penalty, estimate.time, verdict(estimate)));
  for (const std::string& reason : estimate.reasons) rows.emplace_back("", reason);
  return rows;
}

std::string estimate_section(const ErrorEstimate& estimate) {
  Numbers all;
  all.add("Error, estimated", readable(estimate.total, 2), of_words(estimate.of));
  all.add("of the mesh", readable(estimate.space, 2),
          estimate.order ? fmt::format("observed power {:.2g} of the mesh", *estimate.order) : std::string());
  all.add("of the penalty", readable(estimate.penalty, 2));
  all.add("of the time integration", readable(estimate.time, 2));
  if (estimate.requested) all.add("asked for", readable(*estimate.requested, 2), estimate.kept ? "kept" : "not kept");
  all.add("Largest value", readable(estimate.largest));
  if (!estimate.runs.empty()) all.add("Runs for the estimate", estimate.runs.size());
  std::string html = all.html("How far from the bar itself");
  if (!estimate.reasons.empty()) {
    std::string list;
    for (const std::string& reason : estimate.reasons) list += fmt::format("<li>{}</li>\n", escaped(reason));
    html += fmt::format("<ul class=\"note\">\n{}</ul>\n", list);
  }
  return html;
}

std::string no_estimate_section(const std::string& why) {
  return fmt::format("<section><h2>How far from the bar itself</h2>\n<p>There is no estimate: {}</p>\n</section>\n",
                     escaped(why));
}

}  // namespace viscobar
