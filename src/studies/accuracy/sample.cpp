#include "studies/accuracy/sample.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "discretisation/interpolant.hpp"

namespace viscobar::accuracy {

namespace {

using Values = Eigen::Map<const Eigen::ArrayXd>;

}  // namespace

std::vector<double> times_of_errors(double end) {
  constexpr int parts = 250;
  std::vector<double> times;
  for (int k = 0; k < parts; ++k) times.push_back(end / parts * k);
  times.push_back(end);
  return times;
}

Probe::Probe(const Case& run, std::optional<std::size_t> times) {
  constexpr double most_times = 20'000.0, most_values = 1e6;
  const double outputs = times ? static_cast<double>(*times) : std::ceil(run.end / run.output_every) + 1.0;
  time_stride_ = static_cast<std::size_t>(std::ceil(outputs / most_times));
  const double rows = outputs / static_cast<double>(time_stride_);
  constexpr std::size_t enough = 32;
  while (run.elements / (2 * node_stride_) >= enough && run.elements % (2 * node_stride_) == 0 &&
         rows * static_cast<double>(run.elements / node_stride_) > most_values)
    node_stride_ *= 2;
  const Mesh mesh = run.mesh();
  for (std::size_t j = 0; j < mesh.nodes(); j += node_stride_) sample_.x.push_back(mesh.node(j));
  sample_.end = run.end;
  const auto most_rows = static_cast<std::size_t>(rows) + 2;
  sample_.times.reserve(most_rows);
  sample_.u.reserve(most_rows * sample_.x.size());
}

void Probe::add(const Snapshot& snapshot) {
  const bool last = snapshot.time == sample_.end;
  if (seen_++ % time_stride_ != 0 && !last) return;
  sample_.times.push_back(snapshot.time);
  if (node_stride_ == 1)
    sample_.u.insert(sample_.u.end(), snapshot.u.begin(), snapshot.u.end());
  else
    for (std::size_t j = 0; j < snapshot.u.size(); j += node_stride_) sample_.u.push_back(snapshot.u[j]);
  sample_.end_velocities.insert(sample_.end_velocities.end(), {snapshot.v.front(), snapshot.v.back()});
  sample_.speed[0] = std::max(sample_.speed[0], std::abs(snapshot.v.front()));
  sample_.speed[1] = std::max(sample_.speed[1], std::abs(snapshot.v.back()));
}

Sample Probe::take(const Statistics& statistics) {
  if (statistics.account) {
    sample_.impulse = {statistics.account->left.impulse, statistics.account->right.impulse};
    sample_.peak = {statistics.account->left.peak_reaction, statistics.account->right.peak_reaction};
  }
  sample_.statistics = statistics;
  return std::move(sample_);
}

std::optional<Sample> sample_of(const Case& run, const std::function<bool()>& stop) {
  return sample_of(run, run.output_times(), stop);
}

std::optional<Sample> sample_of(const Case& run, std::span<const double> times, const std::function<bool()>& stop,
                                bool peaks) {
  Case plain = run;
  plain.directions.clear();
  const Setup setup = resolve(std::move(plain));
  Probe probe(setup.run, times.size());
  Observers observers;
  observers.account = true;
  observers.off_the_clock = observers.reactions = false;
  observers.extremes = peaks;
  observers.snapshot = [&](const Snapshot& snapshot) { probe.add(snapshot); };
  observers.event = [&](const Event& event) { probe.add(event); };
  if (stop) observers.progress = [&stop](double) { return stop() ? RunControl::stop : RunControl::go_on; };
  const Statistics done = simulate(setup, times, observers);
  if (!done.completed) return std::nullopt;
  return probe.take(done);
}

Sample sample_of(const Case& run, const Recording& recording) {
  Probe probe(run);
  for (std::size_t k = 0; k < recording.times.size(); ++k)
    probe.add(Snapshot{recording.times[k], recording.displacement(k), recording.velocity(k)});
  for (const Event& event : recording.events) probe.add(event);
  return probe.take(recording.statistics);
}

double largest(const Sample& sample, Goal of) {
  double most = 0.0;
  switch (of) {
    case Goal::displacement:
      return Values(sample.u.data(), static_cast<Eigen::Index>(sample.u.size())).abs().maxCoeff();
    case Goal::end_traces:
      for (std::size_t k = 0; k < sample.rows(); ++k)
        most = std::max({most, std::abs(sample.row(k)[0]), std::abs(sample.row(k)[sample.x.size() - 1])});
      return most;
    case Goal::contact_times: return sample.events.empty() ? sample.end : sample.events.back().time;
    case Goal::impulse: return std::max(std::abs(sample.impulse[0]), std::abs(sample.impulse[1]));
    case Goal::peak_reaction: return std::max(sample.peak[0], sample.peak[1]);
    case Goal::end_velocity: return std::max(sample.speed[0], sample.speed[1]);
  }
  return most;
}

namespace {

// A time in contact, up to the end of the run for the last one.
struct Contact {
  double begin = 0.0, end = 0.0, impulse = 0.0, closing_speed = 0.0;
  bool from_start = false, to_end = false;
};

std::vector<Contact> contacts_of(const Sample& sample, Where end) {
  std::vector<Contact> contacts;
  double before = 0.0;
  for (const Event& event : sample.events) {
    if (event.where != end) continue;
    const double impulse = event.impulse.value_or(0.0);
    if (event.change == Change::closing) {
      before = impulse;
      contacts.push_back({event.time, sample.end, 0.0, std::abs(event.velocity), false, true});
      continue;
    }
    if (contacts.empty()) contacts.push_back({.from_start = true});
    contacts.back().end = event.time;
    contacts.back().impulse = impulse - before;
    contacts.back().to_end = false;
  }
  if (!contacts.empty() && contacts.back().to_end)
    contacts.back().impulse = sample.impulse[end == Where::left ? 0 : 1] - before;
  return contacts;
}

// By how much the end moves over the output times within a flight.
double travel(const Sample& sample, Where end, double from, double to) {
  const auto first = std::lower_bound(sample.times.begin(), sample.times.end(), from) - sample.times.begin();
  double low = 1e300, high = -1e300;
  for (auto k = static_cast<std::size_t>(first); k < sample.rows() && sample.times[k] <= to; ++k) {
    const double u = sample.row(k)[end == Where::left ? 0 : sample.x.size() - 1];
    low = std::min(low, u);
    high = std::max(high, u);
  }
  return std::max(0.0, high - low);
}

}  // namespace

Changes changes_that_matter(const Sample& sample, Where end, const Grain& grain) {
  // A flight that is too low makes one contact of its neighbours.
  std::vector<Contact> merged;
  for (const Contact& next : contacts_of(sample, end)) {
    const double flight = merged.empty() ? 0.0 : next.begin - merged.back().end;
    const bool high = merged.empty() || flight * next.closing_speed >= grain.height ||
                      travel(sample, end, merged.back().end, next.begin) >= grain.height;
    if (merged.empty() || (high && flight >= grain.duration)) {
      merged.push_back(next);
      continue;
    }
    Contact& one = merged.back();
    one.end = next.end;
    one.impulse += next.impulse;
    one.to_end = next.to_end;
  }
  Changes changes;
  const double speed = sample.speed[end == Where::left ? 0 : 1];
  for (const Contact& contact : merged) {
    if (std::abs(contact.impulse) < grain.height * grain.impedance || contact.end - contact.begin < grain.duration)
      continue;
    if (changes.times.empty()) changes.first_closes = !contact.from_start;
    if (!contact.from_start) changes.times.push_back(contact.begin);
    const double rest = sample.end - contact.end;
    if (!contact.to_end && rest >= grain.duration && rest * speed >= grain.height) changes.times.push_back(contact.end);
  }
  return changes;
}

namespace {

// At a node up to rounding that one.
Interpolant interpolant_or_node(const std::vector<double>& x, double at) {
  const double close = 1e-9 * (x.back() - x.front());
  const auto right = std::lower_bound(x.begin(), x.end(), at - close);
  const auto index = static_cast<std::size_t>(std::min(right, x.end() - 1) - x.begin());
  return std::abs(x[index] - at) <= close ? Interpolant{.begin = index} : interpolant(x, at);
}

// The first rows of a run at some places, row by row; what is copied of them is in `copy`. On meshes that are halves of
// each other the places are each n-th node.
Values at_places(const Sample& sample, const std::vector<double>& places, std::size_t rows, std::vector<double>& copy) {
  const std::size_t count = places.size(), width = sample.x.size();
  std::vector<Interpolant> rules;
  for (const double x : places) rules.push_back(interpolant_or_node(sample.x, x));
  const std::size_t stride = count > 1 ? rules[1].begin : 1;
  bool regular = true;
  for (std::size_t i = 0; i < count; ++i) regular = regular && rules[i].count == 1 && rules[i].begin == i * stride;
  const auto size = static_cast<Eigen::Index>(rows * count);
  if (regular && stride == 1 && count == width) return {sample.u.data(), size};
  copy.resize(rows * count);
  double* to = copy.data();
  for (std::size_t k = 0; k < rows; ++k) {
    const double* row = sample.row(k);
    if (regular)
      for (std::size_t i = 0; i < count; ++i) *to++ = row[i * stride];
    else
      for (const Interpolant& rule : rules) *to++ = rule.value({row, width});
  }
  return {copy.data(), size};
}

// The goals that are a few numbers of a run.
std::vector<double> numbers(const Sample& sample, Goal of, const Grain& grain) {
  std::vector<double> all;
  if (of == Goal::impulse) all.assign(sample.impulse.begin(), sample.impulse.end());
  if (of == Goal::peak_reaction) all.assign(sample.peak.begin(), sample.peak.end());
  if (of == Goal::contact_times)
    for (const Where end : {Where::left, Where::right}) {
      const Changes changes = changes_that_matter(sample, end, grain);
      all.insert(all.end(), changes.times.begin(), changes.times.end());
    }
  return all;
}

// Calls visit(u) with what the goal is of, u[n] being that of run n: of a field the values at the places of the first
// run, time by time.
void compare(const std::vector<const Sample*>& samples, Goal of, const Grain& grain, auto&& visit) {
  std::vector<std::vector<double>> copies(samples.size());
  std::vector<Values> u;
  if (of == Goal::end_velocity) {
    const std::size_t rows = std::ranges::min(samples, {}, &Sample::rows)->rows();
    for (const Sample* sample : samples)
      u.emplace_back(sample->end_velocities.data(), static_cast<Eigen::Index>(2 * rows));
  } else if (is_field(of)) {
    const std::vector<double>& x = samples.front()->x;
    const std::vector<double> places = of == Goal::displacement ? x : std::vector<double>{x.front(), x.back()};
    const std::size_t rows = std::ranges::min(samples, {}, &Sample::rows)->rows();
    for (std::size_t n = 0; n < samples.size(); ++n) u.push_back(at_places(*samples[n], places, rows, copies[n]));
  } else {
    for (std::size_t n = 0; n < samples.size(); ++n) copies[n] = numbers(*samples[n], of, grain);
    const std::size_t count = std::ranges::min(copies, {}, &std::vector<double>::size).size();
    for (const std::vector<double>& all : copies) u.emplace_back(all.data(), static_cast<Eigen::Index>(count));
  }
  if (u.front().size() > 0) visit(u);
}

}  // namespace

bool is_field(Goal of) { return of == Goal::displacement || of == Goal::end_traces || of == Goal::end_velocity; }

SameChanges compare_changes(const Sample& coarse, const Sample& fine, const Grain& grain) {
  SameChanges result;
  for (const Where end : {Where::left, Where::right}) {
    const Changes a = changes_that_matter(coarse, end, grain), b = changes_that_matter(fine, end, grain);
    result.coarse += a.times.size();
    result.fine += b.times.size();
    if (a.times.size() != b.times.size() || a.first_closes != b.first_closes) result.same = false;
  }
  return result;
}

double difference(const Sample& coarse, const Sample& fine, Goal of, const Grain& grain) {
  double largest = 0.0;
  compare({&coarse, &fine}, of, grain, [&](const auto& u) { largest = (u[0] - u[1]).abs().maxCoeff(); });
  return largest;
}

double alignment(const Sample& first, const Sample& second, const Sample& third, Goal of, const Grain& grain) {
  double cosine = 1.0;
  compare({&first, &second, &third}, of, grain, [&](const auto& u) {
    const double before = (u[1] - u[0]).square().sum(), after = (u[2] - u[1]).square().sum();
    if (before > 0.0 && after > 0.0) cosine = ((u[1] - u[0]) * (u[2] - u[1])).sum() / std::sqrt(before * after);
  });
  return cosine;
}

}  // namespace viscobar::accuracy
