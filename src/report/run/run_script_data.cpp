#include "report/run/run_script_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "report/obstacle_levels.hpp"
#include "report/plot/png.hpp"
#include "report/plot/range.hpp"
#include "results/csv.hpp"
#include "scene/end_kinds.hpp"
#include "text/json_text.hpp"

namespace viscobar {

namespace {

using plot::json_numbers;
using plot::json_string;

constexpr auto itself = [](double value) { return value; };
constexpr int digits_of_time = 9;

std::string sides_json(const Obstacle& obstacle) {
  return fmt::format(R"(,"gap":{:.9g}{})", obstacle.gap, obstacle.side == Side::above ? R"(,"above":true)" : "");
}

std::string support_json(const EndCondition& end, const EndInput& input, const ReportData& data,
                         const ReportData::End& trace, double reached) {
  std::string text = fmt::format(R"({{"kind":"{}")", end_kind(end).name);
  const auto* body = std::get_if<Obstacle>(&end);
  if (!body) return text + '}';
  text += sides_json(*body);
  std::vector<double> surface, ends;
  for (std::size_t row = 0; input.motion && row < data.field.rows(); ++row)
    surface.push_back(surface_at(*body, input, data.field.time(row)));
  if (input.motion) text += R"(,"surface":)" + json_numbers(surface, itself, digits_of_time);
  for (const plot::Interval& part : trace.in_contact(reached)) ends.insert(ends.end(), {part.begin, part.end});
  return text + R"(,"contact":)" + json_numbers(ends, itself, digits_of_time) + '}';
}

}  // namespace

std::string field_json(const ThinnedField& field, const FieldColours& colours) {
  plot::Range range;
  std::vector<double> times;
  for (std::size_t row = 0; row < field.rows(); ++row) {
    times.push_back(field.time(row));
    for (const double u : field.row(row)) range.add(u);
  }
  const double size = range.high - range.low;
  std::string bytes;
  bytes.reserve(2 * field.rows() * field.x().size());
  for (std::size_t row = 0; row < field.rows(); ++row)
    for (const double u : field.row(row)) {
      const double part = size > 0.0 && std::isfinite(u) ? std::clamp((u - range.low) / size, 0.0, 1.0) : 0.0;
      const auto q = static_cast<std::uint16_t>(std::lround(65535.0 * part));
      bytes += static_cast<char>(q & 0xff);
      bytes += static_cast<char>(q >> 8);
    }
  std::string anchors;
  for (const plot::Colour colour : colours.map.anchors)
    anchors += fmt::format("{}\"{}\"", anchors.empty() ? "" : ",", plot::hex(colour));
  std::string level;
  if (std::isfinite(colours.contact_up_to)) level += fmt::format(R"(,"contactLevel":{:.9g})", colours.contact_up_to);
  if (std::isfinite(colours.contact_from)) level += fmt::format(R"(,"contactFrom":{:.9g})", colours.contact_from);
  return fmt::format(R"({{"everyTime":{},"everyNode":{},"low":{:.9g},"high":{:.9g},"t":{},"x":{},)"
                     R"("colours":{{"anchors":[{}],"low":{:.9g},"high":{:.9g},"touching":"{}"{}}},"u":"{}"}})",
                     field.time_stride(), field.node_stride(), range.low, range.high,
                     json_numbers(times, itself, digits_of_time), json_numbers(field.x(), itself, digits_of_time),
                     anchors, colours.values.low, colours.values.high, plot::hex(FieldColours::touching), level,
                     plot::base64(bytes));
}

std::string events_json(const ReportData& data, std::size_t happened) {
  const std::vector<Event>& events = data.marked_events.events();
  std::map<std::string, std::size_t> number_of;
  std::string places, where;
  for (const Event& event : events) {
    const auto [known, added] = number_of.emplace(place(event), number_of.size());
    if (added) places += fmt::format("{}{}", places.empty() ? "" : ",", json_string(known->first));
    where += fmt::format("{}{}", where.empty() ? "" : ",", known->second);
  }
  const auto column = [&](auto value, int digits) { return json_numbers(events, value, digits); };
  return fmt::format(R"({{"happened":{},"every":{},"places":[{}],"place":[{}],"t":{},"closes":{},"velocity":{}}})",
                     happened, data.marked_events.stride(), places, where,
                     column([](const Event& e) { return e.time; }, digits_of_time),
                     column([](const Event& e) { return e.change == Change::closing ? 1.0 : 0.0; }, 1),
                     column([](const Event& e) { return e.velocity; }, 6));
}

std::string supports_json(const Scene& scene, const Outcome& outcome, const ReportData& data) {
  const double reached = outcome.reached_time;
  std::string text =
      fmt::format(R"({{"left":{},"right":{})", support_json(scene.left, scene.left_input, data, data.left, reached),
                  support_json(scene.right, scene.right_input, data, data.right, reached));
  if (scene.span) text += fmt::format(R"(,"span":{{"side":"{}"{}}})", name(scene.span->side), sides_json(*scene.span));
  return text + '}';
}

}  // namespace viscobar
