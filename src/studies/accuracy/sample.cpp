#include "studies/accuracy/sample.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "discretisation/interpolant.hpp"
#include "dynamics/pieces.hpp"
#include "studies/touch.hpp"

namespace viscobar::accuracy {

namespace {

using Values = Eigen::Map<const Eigen::ArrayXd>;

// Where an end or a joint has its numbers in a sample.
std::size_t index_of(Where end, std::size_t joint) { return joint > 0 ? 1 + joint : end == Where::left ? 0 : 1; }

// Displacement of an end in a row, or how far the sides of a joint are apart.
double opening(const Sample& sample, const double* row, Where end, std::size_t joint) {
  if (joint == 0) return row[end == Where::left ? 0 : sample.x.size() - 1];
  const std::size_t right = sample.right_of(joint);
  return row[right] - row[right - 1];
}

// use(where, joint) for each place that may have contacts: both ends, and joints of a chain that are not bonded.
void each_place(const Sample& sample, auto&& use) {
  use(Where::left, 0);
  use(Where::right, 0);
  for (std::size_t k = 1; k < sample.members.size(); ++k)
    if (sample.right_of(k) > 0) use(Where::joint, k);
}

}  // namespace

std::size_t fewest_in_a_bar(const Case& run) {
  if (run.scene.chain.empty()) return run.elements;
  std::size_t fewest = run.elements;
  const Mesh mesh = run.mesh();
  for (const Mesh& own : *mesh.members)
    if (own.elements > 0) fewest = std::min(fewest, own.elements);
  return fewest;
}

Case on_mesh(Case run, const Mesh& mesh) {
  run.elements = mesh.elements_of_bars();
  if (mesh.members) run.bar_meshes = *mesh.members;
  return run;
}

std::optional<std::vector<std::size_t>> refine_by_one_factor(Case& run, std::vector<std::size_t> meshes) {
  if (run.scene.chain.empty() || meshes.empty()) return meshes;
  const std::size_t fewest = *std::ranges::min_element(meshes);
  if (std::ranges::any_of(meshes, [&](std::size_t count) { return count % fewest != 0; })) return std::nullopt;
  run.elements = fewest;
  run = on_its_mesh(std::move(run));
  for (std::size_t& count : meshes) count = count / fewest * run.elements;
  return meshes;
}

std::vector<double> times_of_errors(double end) {
  constexpr int parts = 250;
  std::vector<double> times;
  for (int k = 0; k < parts; ++k) times.push_back(end / parts * k);
  times.push_back(end);
  return times;
}

Probe::Probe(const Case& run, std::size_t times) {
  constexpr std::size_t enough = 32, most_values = 1'000'000;
  while (run.scene.chain.empty() && run.elements / (2 * node_stride_) >= enough &&
         run.elements % (2 * node_stride_) == 0 && times * (run.elements / node_stride_) > most_values)
    node_stride_ *= 2;
  const Mesh mesh = run.mesh();
  for (std::size_t j = 0; j < mesh.nodes(); j += node_stride_) sample_.x.push_back(mesh.node(j));
  if (run.scene.chain.empty())
    sample_.members = {{0, sample_.x.size()}};
  else
    for (const Piece& piece : pieces_of(run.scene, mesh)) sample_.members.push_back({piece.first, piece.last() + 1});
  for (std::vector<double>* one : {&sample_.impulse, &sample_.peak, &sample_.speed})
    one->resize(1 + sample_.members.size());
  sample_.end = run.end;
  sample_.times.reserve(times);
  sample_.u.reserve(times * sample_.x.size());
}

void Probe::add(const Snapshot& snapshot) {
  sample_.times.push_back(snapshot.time);
  if (node_stride_ == 1)
    sample_.u.insert(sample_.u.end(), snapshot.u.begin(), snapshot.u.end());
  else
    for (std::size_t j = 0; j < snapshot.u.size(); j += node_stride_) sample_.u.push_back(snapshot.u[j]);
  sample_.end_velocities.insert(sample_.end_velocities.end(), {snapshot.v.front(), snapshot.v.back()});
  each_place(sample_, [&](Where end, std::size_t joint) {
    double& speed = sample_.speed[index_of(end, joint)];
    speed = std::max(speed, std::abs(joint > 0            ? opening(sample_, snapshot.v.data(), end, joint)
                                     : end == Where::left ? snapshot.v.front()
                                                          : snapshot.v.back()));
  });
}

Sample Probe::take(const Statistics& statistics) {
  if (statistics.account) {
    const RunAccount& account = *statistics.account;
    sample_.impulse[0] = account.left.impulse, sample_.impulse[1] = account.right.impulse;
    sample_.peak[0] = account.left.peak_reaction, sample_.peak[1] = account.right.peak_reaction;
    for (std::size_t k = 0; k < account.joints.size(); ++k)
      sample_.impulse[2 + k] = account.joints[k].impulse, sample_.peak[2 + k] = account.joints[k].peak_reaction;
  }
  sample_.statistics = statistics;
  return std::move(sample_);
}

Sample sample_of(const Case& run, std::span<const double> times, const RunLimits& limits, bool peaks) {
  const Setup setup = resolve(run);
  Probe probe(run, times.size());
  Observers observers;
  observers.account = true;
  observers.off_the_clock = observers.reactions = false;
  observers.extremes = {.ranges = false, .peaks = peaks};
  observers.snapshot = [&](const Snapshot& snapshot) { probe.add(snapshot); };
  observers.event = [&](const Event& event) { probe.add(event); };
  return probe.take(simulate_within(limits, setup, setup.system(), times, observers));
}

namespace {

// By how much the end moves over the output times within a flight.
double travel(const Sample& sample, Where end, std::size_t joint, double from, double to) {
  const auto first = std::lower_bound(sample.times.begin(), sample.times.end(), from) - sample.times.begin();
  double low = 1e300, high = -1e300;
  for (auto k = static_cast<std::size_t>(first); k < sample.rows() && sample.times[k] <= to; ++k) {
    const double u = opening(sample, sample.row(k), end, joint);
    low = std::min(low, u);
    high = std::max(high, u);
  }
  return std::max(0.0, high - low);
}

}  // namespace

Changes changes_that_matter(const Sample& sample, Where end, const Resolution& resolution, std::size_t joint) {
  // A flight that is too low makes one contact of its neighbours.
  const auto low = [&](const Touch& one, const Touch& next) {
    const double from = one.end(sample.end), flight = next.begin() - from;
    const bool high = flight * std::abs(next.closing->velocity) >= resolution.height ||
                      travel(sample, end, joint, from, next.begin()) >= resolution.height;
    return !high || flight < resolution.duration;
  };
  Changes changes;
  const std::size_t index = index_of(end, joint);
  for (const Touch& touch : touches(changes_at(sample.events, end, joint), low)) {
    const double begin = touch.begin(), until = touch.end(sample.end), rest = sample.end - until;
    if (std::abs(touch.impulse(sample.impulse[index])) < resolution.height * resolution.impedance ||
        until - begin < resolution.duration)
      continue;
    if (changes.times.empty()) changes.first_closes = touch.closing != nullptr;
    if (touch.closing) changes.times.push_back(begin);
    if (touch.opening && rest >= resolution.duration && rest * sample.speed[index] >= resolution.height)
      changes.times.push_back(until);
  }
  return changes;
}

namespace {

// A place of a run, and the member of its chain that it is of.
struct Place {
  std::size_t member;
  double x;
};

std::vector<Place> places_of(const Sample& sample, Goal of) {
  const std::vector<double>& x = sample.x;
  if (of != Goal::displacement) return {{0, x.front()}, {sample.members.size() - 1, x.back()}};
  std::vector<Place> places;
  for (std::size_t i = 0, member = 0; i < x.size(); ++i) {
    while (i >= sample.members[member].end) ++member;  // a node that two have is the left one's
    places.push_back({member, x[i]});
  }
  return places;
}

// At a node up to rounding that one.
Interpolant interpolant_or_node(std::span<const double> x, double at) {
  const double close = 1e-9 * (x.back() - x.front());
  const auto right = std::lower_bound(x.begin(), x.end(), at - close);
  const auto index = static_cast<std::size_t>(std::min(right, x.end() - 1) - x.begin());
  return std::abs(x[index] - at) <= close ? Interpolant{.begin = index} : interpolant(x, at);
}

// The first rows of a run at some places, row by row; what is copied of them is in `copy`. On meshes that are halves of
// each other the places are each n-th node.
Values at_places(const Sample& sample, const std::vector<Place>& places, std::size_t rows, std::vector<double>& copy) {
  const std::size_t count = places.size(), width = sample.x.size();
  std::vector<Interpolant> rules;
  for (const auto& [member, x] : places) {
    const auto [first, end] = sample.members[member];
    rules.push_back(interpolant_or_node(std::span(sample.x).subspan(first, end - first), x));
    rules.back().begin += first;
  }
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
std::vector<double> numbers(const Sample& sample, Goal of, const Resolution& resolution) {
  std::vector<double> all;
  if (of == Goal::impulse) return sample.impulse;
  if (of == Goal::peak_reaction) return sample.peak;
  if (of == Goal::contact_times)
    each_place(sample, [&](Where end, std::size_t joint) {
      const Changes changes = changes_that_matter(sample, end, resolution, joint);
      all.insert(all.end(), changes.times.begin(), changes.times.end());
    });
  return all;
}

// Calls visit(u) with what the goal is of, u[n] being that of run n: of a field the values at the places of the first
// run, time by time.
void compare(const std::vector<const Sample*>& samples, Goal of, const Resolution& resolution, auto&& visit) {
  std::vector<std::vector<double>> copies(samples.size());
  std::vector<Values> u;
  if (of == Goal::end_velocity) {
    const std::size_t rows = std::ranges::min(samples, {}, &Sample::rows)->rows();
    for (const Sample* sample : samples)
      u.emplace_back(sample->end_velocities.data(), static_cast<Eigen::Index>(2 * rows));
  } else if (is_field(of)) {
    const std::vector<Place> places = places_of(*samples.front(), of);
    const std::size_t rows = std::ranges::min(samples, {}, &Sample::rows)->rows();
    for (std::size_t n = 0; n < samples.size(); ++n) u.push_back(at_places(*samples[n], places, rows, copies[n]));
  } else {
    for (std::size_t n = 0; n < samples.size(); ++n) copies[n] = numbers(*samples[n], of, resolution);
    const std::size_t count = std::ranges::min(copies, {}, &std::vector<double>::size).size();
    for (const std::vector<double>& all : copies) u.emplace_back(all.data(), static_cast<Eigen::Index>(count));
  }
  if (u.front().size() > 0) visit(u);
}

}  // namespace

bool is_field(Goal of) { return of == Goal::displacement || of == Goal::end_traces || of == Goal::end_velocity; }

SameChanges compare_changes(const Sample& coarse, const Sample& fine, const Resolution& resolution) {
  SameChanges result;
  each_place(coarse, [&](Where end, std::size_t joint) {
    const Changes a = changes_that_matter(coarse, end, resolution, joint),
                  b = changes_that_matter(fine, end, resolution, joint);
    result.coarse += a.times.size();
    result.fine += b.times.size();
    if (a.times.size() != b.times.size() || a.first_closes != b.first_closes) result.same = false;
  });
  return result;
}

double largest(const Sample& sample, Goal of) {
  if (of == Goal::contact_times) return sample.events.empty() ? sample.end : sample.events.back().time;
  double largest = 0.0;
  compare({&sample}, of, {}, [&](const auto& u) { largest = u[0].abs().maxCoeff(); });
  return largest;
}

double difference(const Sample& coarse, const Sample& fine, Goal of, const Resolution& resolution) {
  double largest = 0.0;
  compare({&coarse, &fine}, of, resolution, [&](const auto& u) { largest = (u[0] - u[1]).abs().maxCoeff(); });
  return largest;
}

double alignment(const Sample& first, const Sample& second, const Sample& third, Goal of,
                 const Resolution& resolution) {
  double cosine = 1.0;
  compare({&first, &second, &third}, of, resolution, [&](const auto& u) {
    const double before = (u[1] - u[0]).square().sum(), after = (u[2] - u[1]).square().sum();
    if (before > 0.0 && after > 0.0) cosine = ((u[1] - u[0]) * (u[2] - u[1])).sum() / std::sqrt(before * after);
  });
  return cosine;
}

}  // namespace viscobar::accuracy
