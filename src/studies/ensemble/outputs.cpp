#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "run/contact_places.hpp"
#include "studies/column_reader.hpp"
#include "text/number.hpp"
#include "viscobar/studies/ensemble/ensemble.hpp"

namespace viscobar {

namespace {

constexpr std::string_view known =
    "an output is COLUMN@EVERY with a column of ends.csv or joints.csv, gauge:X@EVERY, events:COUNT, impulse_left, "
    "impulse_right, impulse_joint:K, the same of peak, or final";

[[noreturn]] void refuse(std::string_view text, std::string_view why) {
  throw std::invalid_argument(fmt::format("outputs: \"{}\" {}; {}", text, why, known));
}

double read_number(std::string_view text, std::string_view digits) {
  if (const auto value = number_in<double>(digits)) return *value;
  refuse(text, fmt::format("has \"{}\" where a number belongs", digits));
}

}  // namespace

std::size_t EnsembleOutput::width() const {
  return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
}

bool is_shared_by_bars(std::string_view key) {
  return key == "time.end" || key == "mesh.elements" || key == "mesh.grading" || key == "output.every";
}

EnsembleOutput ensemble_output(std::string_view text, const Case& run) {
  using Kind = EnsembleOutput::Kind;
  EnsembleOutput output;
  output.name = text;
  for (const auto& [kind, word] : {std::pair{Kind::impulse, std::string("impulse_")}, {Kind::peak, "peak_"}}) {
    output.kind = kind;
    output.account = 0;
    if (text == word + "left") return output;
    output.account = 1;
    if (text == word + "right") return output;
    for (const ContactPlace& place : contact_places(run.scene)) {
      output.account = 1 + place.joint;
      if (place.joint > 0 && text == fmt::format("{}joint:{}", word, place.joint)) return output;
    }
  }
  if (text == "final") {
    output.kind = Kind::final;
    output.shape = {2, run.mesh().nodes()};
    return output;
  }
  if (text.starts_with("events:")) {
    output.kind = Kind::events;
    const double count = read_number(text, text.substr(7));
    if (!(count >= 1.0 && count <= 1e6 && count == std::floor(count))) refuse(text, "wants a whole number from 1 on");
    output.most = static_cast<std::size_t>(count);
    output.shape = {output.most};
    return output;
  }
  const std::size_t at = text.rfind('@');
  const std::string_view what = text.substr(0, at);
  const bool gauge = what.starts_with("gauge:");
  const auto column = gauge ? std::nullopt : trace_column(what);
  if (!gauge && (!column || is_of_gauge(column->first))) refuse(text, "is not known");
  if (!gauge && is_of_joint(column->first))
    if (const auto why = place_refusal(column, run.scene)) refuse(text, *why);
  if (at == text.npos) refuse(text, "does not say how often: @0.1 is every 0.1");
  Case every = run;
  every.output_every = read_number(text, text.substr(at + 1));
  if (!(every.output_every > 0.0 && run.end / every.output_every <= 1e7))
    refuse(text, "wants a positive interval, and no more than 1e7 of them in the run");
  output.times = every.output_times();
  output.shape = {output.times.size()};
  output.kind = gauge ? Kind::gauge : Kind::trace;
  if (!gauge) {
    output.column = column->first, output.place = column->second;
    return output;
  }
  output.place = read_number(text, what.substr(6));
  if (!(output.place >= 0.0 && output.place <= run.scene.bar.length))
    refuse(text, fmt::format("is outside of the bar, 0 to {}", run.scene.bar.length));
  output.shape.push_back(4);
  return output;
}

namespace {

struct Words {
  std::string_view name, meaning;
};

constexpr std::array<Words, 5> of_status = {{
    {"kept", "at the end, and within the error where one was asked for"},
    {"not_kept", "at the end, its estimate above the error that was asked for, or none made"},
    {"failed", "stopped before the end"},
    {"faulty", "its scene cannot be run"},
    {"not_run", "the ensemble was stopped before"},
}};
constexpr std::array<std::string_view, 3> of_way = {"none", "lanes", "alone"};

}  // namespace

std::string_view name(BarStatus status) { return of_status[static_cast<std::size_t>(status)].name; }
std::string_view meaning(BarStatus status) { return of_status[static_cast<std::size_t>(status)].meaning; }
std::string_view name(BarWay way) { return of_way[static_cast<std::size_t>(way)]; }

}  // namespace viscobar
