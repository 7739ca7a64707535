#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>

#include "report/plot/png.hpp"
#include "report/run/run_page.hpp"
#include "report/scene_ends.hpp"
#include "results/csv.hpp"
#include "scene/end_kinds.hpp"
#include "scene/unit_names.hpp"
#include "text/joined.hpp"
#include "text/json_text.hpp"

namespace viscobar {

namespace {

using plot::json_numbers;
using plot::json_string;

std::string sides_json(const Obstacle& obstacle) {
  return fmt::format(R"(,"gap":{:.9g}{})", obstacle.gap, obstacle.side == Side::above ? R"(,"above":true)" : "");
}

constexpr int digits_of_time = 9;
std::string numbers(const std::vector<double>& values, int digits = digits_of_time) {
  return json_numbers(values, std::identity(), digits);
}

std::string contacts_json(const std::vector<plot::Interval>& parts) {
  std::vector<double> contact, peaks;
  for (const plot::Interval& part : parts) {
    contact.insert(contact.end(), {part.begin, part.end});
    peaks.insert(peaks.end(), {part.peak.x, part.peak.y});
  }
  return R"(,"contact":)" + numbers(contact) + R"(,"peaks":)" + numbers(peaks) + '}';
}

std::string support_json(const SceneEnd& end, const ReportData& data, const std::vector<plot::Interval>& contacts) {
  std::string text = fmt::format(R"({{"kind":"{}")", end_kind(end.condition).name);
  if (!end.obstacle()) return text + '}';
  text += sides_json(*end.obstacle());
  if (end.input.motion) text += R"(,"surface":)" + numbers(end.surface(data.field.times()));
  return text + contacts_json(contacts);
}

}  // namespace

std::string field_json(const ThinnedField& field, const FieldColours& colours) {
  const plot::Range& range = colours.range;
  const double size = range.high - range.low;
  std::string bytes;
  bytes.reserve(2 * field.rows() * field.x().size());
  for (std::size_t row = 0; row < field.rows(); ++row)
    for (const double u : field.row(row)) {
      const double part = size > 0.0 && std::isfinite(u) ? std::clamp((u - range.low) / size, 0.0, 1.0) : 0.0;
      const auto q = static_cast<std::uint16_t>(65535.0 * part + 0.5);
      bytes += static_cast<char>(q & 0xff);
      bytes += static_cast<char>(q >> 8);
    }
  std::string anchors;
  for (const plot::Colour colour : colours.map.anchors)
    anchors += fmt::format("{}\"{}\"", anchors.empty() ? "" : ",", plot::hex(colour));
  std::string level;
  if (std::isfinite(colours.contact_up_to)) level += fmt::format(R"(,"contactUpTo":{:.9g})", colours.contact_up_to);
  if (std::isfinite(colours.contact_from)) level += fmt::format(R"(,"contactFrom":{:.9g})", colours.contact_from);
  return joined({fmt::format(R"({{"everyTime":{},"everyNode":{},"low":{:.9g},"high":{:.9g},"t":{},"x":{},)"
                             R"("colours":{{"anchors":[{}],"low":{:.9g},"high":{:.9g}{}}},"u":")",
                             field.time_stride(), field.node_stride(), range.low, range.high, numbers(field.times()),
                             numbers(field.x()), anchors, colours.values.low, colours.values.high, level),
                 plot::base64(bytes), "\"}"});
}

std::string events_json(const ReportData& data, std::size_t happened) {
  std::map<std::string, std::size_t> number_of;
  std::string places, where;
  std::vector<double> t, closes, velocity;
  for (const auto& [event] : data.marked_events.buckets()) {
    const auto [known, added] = number_of.emplace(place(event), number_of.size());
    if (added) places += fmt::format("{}{}", places.empty() ? "" : ",", json_string(known->first));
    where += fmt::format("{}{}", where.empty() ? "" : ",", known->second);
    t.push_back(event.time);
    closes.push_back(event.change == Change::closing ? 1.0 : 0.0);
    velocity.push_back(event.velocity);
  }
  return fmt::format(R"({{"happened":{},"every":{},"places":[{}],"place":[{}],"t":{},"closes":{},"velocity":{}}})",
                     happened, data.marked_events.stride(), places, where, numbers(t), numbers(closes),
                     numbers(velocity, 6));
}

std::string supports_json(const Scene& scene, const Outcome& outcome, const ReportData& data) {
  const auto [left, right] = ends_of(scene);
  std::string text =
      fmt::format(R"({{"left":{},"right":{})", support_json(left, data, contacts_of(left.place(), outcome, data)),
                  support_json(right, data, contacts_of(right.place(), outcome, data)));
  if (scene.span)
    text += fmt::format(R"(,"span":{{"side":"{}"{}{})", name(scene.span->side), sides_json(*scene.span),
                        contacts_json(contacts_of({Where::span}, outcome, data)));
  return text + '}';
}

std::string axial_json(const Case& run, const Outcome& outcome, const ReportData& data) {
  const AxialLayout layout = axial_layout(run, data);
  const auto places = [](const ThinnedField::Part& part) { return fmt::format("[{},{}]", part.first, part.last()); };
  std::string members, joints;
  for (std::size_t m = 0; m < layout.members.size(); ++m) {
    const auto& [rigid, shift] = layout.members[m];
    members += fmt::format(R"({}{{"nodes":{},{}"shift":{:.9g}}})", m > 0 ? "," : "", places(data.field.parts()[m]),
                           rigid ? "" : fmt::format(R"("elements":{},)", places(data.stress.parts()[m])), shift);
    if (m == 0) continue;
    const JointKind kind = run.scene.chain[m - 1].joint.kind;
    joints +=
        fmt::format(R"({}{{"kind":"{}"{})", m > 1 ? "," : "", name(kind),
                    kind == JointKind::contact ? contacts_json(contacts_of({Where::joint, m}, outcome, data)) : "}");
  }
  return fmt::format(R"({{"magnification":{},"block":{:.9g},"members":[{}],"joints":[{}]}})", layout.magnification,
                     layout.block, members, joints);
}

std::string units_json(const Units& units) {
  constexpr std::pair<const char*, Dimension> quantities[] = {{"length", Dimension::length},
                                                              {"time", Dimension::time},
                                                              {"velocity", Dimension::velocity},
                                                              {"stress", Dimension::stress},
                                                              {"force", Dimension::force}};
  std::string all;
  for (const auto& [quantity, dimension] : quantities)
    all += fmt::format(R"({}"{}":{})", all.empty() ? "" : ",", quantity,
                       json_string(squares(unit_name(units, dimension))));
  return "{" + all + "}";
}

}  // namespace viscobar
