#include "characteristics/run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <utility>
#include <variant>

#include "run/step_failure.hpp"

namespace viscobar::characteristics {

namespace {

constexpr std::size_t rough_awaited = 3'000;  // evaluations for one window, by a look ahead

// The load of a scene along a bar.
Load load_along(const Load& of_scene, double begin) {
  Load load = of_scene;
  const auto shift = [begin](NextBreak& places) {
    if (places) places = along(places, begin);
  };
  if (auto* steady = std::get_if<SteadyLoad>(&load)) {
    steady->profile = [profile = steady->profile, begin](double x) { return profile(begin + x); };
    shift(steady->places.breaks), shift(steady->places.detail);
  } else if (auto* separable = std::get_if<SeparableLoad>(&load)) {
    separable->profile = [profile = separable->profile, begin](double x) { return profile(begin + x); };
    shift(separable->places.breaks), shift(separable->places.detail);
  } else if (auto* general = std::get_if<GeneralLoad>(&load)) {
    general->density = [density = general->density, begin](double x, double t) { return density(begin + x, t); };
  }
  return load;
}

}  // namespace

Run::Run(const Scene& scene, const Mesh& mesh, const Checkpoint* from, std::span<const double> times,
         const Characteristics& method, const Observers& observers, double most_work)
    : scene_(scene),
      mesh_(mesh),
      times_(times),
      observers_(observers),
      method_(method),
      most_work_(most_work),
      from_(from),
      statistics_(from ? from->statistics : Statistics{}),
      load_evaluations_before_(statistics_.load_evaluations),
      notifier_(observers, statistics_),
      t_(from ? from->time : times.front()),
      schedule_(observers, times, t_),
      bars_(bars_of(scene_)),
      window_(window_of(bars_)) {
  for (const LineBar& bar : bars_) {
    data_.push_back(initial_data(scene_, bar));
    lines_.push_back({DelayLine(bar.transit() / window_), DelayLine(bar.transit() / window_)});
    if (!scene.load) continue;
    const Bar of_load{bar.length, bar.density, bar.density * bar.speed * bar.speed, 0.0};
    loads_.push_back(LoadGain::of(bar.begin == 0.0 ? *scene.load : load_along(*scene.load, bar.begin), of_load,
                                  bar.transit(), lines_.back().rightward.delay(), times.front(), times.back()));
  }
  junctions_ = junctions_of(scene_, bars_, window_, times.front(), &data_, &places_);
  if (observers_.energy)
    for (Junction& junction : junctions_) junction.keep_energy();
  gained_.resize(loads_.size());
  if (std::isfinite(most_work))
    for (const auto& load : loads_) load->most_rough = rough_awaited;
  if (observers_.snapshot) {
    u_.resize(mesh.nodes()), v_.resize(mesh.nodes());
    pieces_ = pieces_of(scene_, mesh_);
  }
  const double until = (times.back() - times.front()) / window_;
  last_window_ = static_cast<std::size_t>(std::max(0.0, std::ceil(until) - 1.0));
  if (last_window_ > 0 && until - static_cast<double>(last_window_) < least_window) --last_window_;
}

PartEnd Run::operator()() {
  return part_or_failure(
      "characteristics", [&] { return reached(); },
      [&]() -> PartEnd {
        if (from_)
          go_on(*from_);
        else
          begin();
        for (;; ++k_) {
          enter();
          if (auto end = tell_window()) return std::move(*end);
          if (k_ == last_window_) break;
          leave();
          if (worked() > most_work_) return reached();
        }
        finish();
        return reached();
      });
}

double Run::worked() const {
  double work = carried_;
  for (const auto& load : loads_) work += work_of_evaluation * static_cast<double>(load->evaluations());
  return work;
}

Statistics Run::reached() {
  statistics_.reached_time = t_;
  statistics_.load_evaluations = load_evaluations_before_;
  statistics_.event_evaluations = 0;
  double velocity_error = now_.error, displacement_error = 0.0;
  for (const auto& load : loads_) {
    statistics_.load_evaluations += load->evaluations();
    velocity_error += load->memory.arrivals + load->memory.looked_at;
  }
  for (const Junction& junction : junctions_) {
    statistics_.event_evaluations += junction.memory().searched;
    velocity_error += junction.memory().error;
  }
  for (const InitialData& data : data_)
    velocity_error += data.velocity_error, displacement_error += data.displacement_error;
  statistics_.unknowns = largest_;
  notifier_.count_seconds();
  account();
  const double duration = t_ - times_.front();
  const double windows = static_cast<double>(k_) + 1.0;
  statistics_.representation = {displacement_error + duration * velocity_error,
                                rounding * windows * (now_.place_scale + duration * now_.velocity_scale),
                                now_.velocity_scale};
  return statistics_;
}

void Run::go_on(const Checkpoint& checkpoint) {
  restore(*this, checkpoint, times_, observers_);
  if (nodes_ != mesh_.nodes())
    throw std::invalid_argument("the checkpoint is of another run than the one to go on with");
  for (std::size_t b = 0; b < loads_.size(); ++b) {
    const std::size_t windows = lines_[b].rightward.windows();
    for (std::size_t k = k_ > windows ? k_ - windows : 0; k < k_ && !loads_[b]->steady(); ++k) loads_[b]->recall(k);
    loads_[b]->memory = gains_begin_[b];
  }
  for (Junction& junction : junctions_) junction.restore();
  now_ = begin_;
  next_output_ = checkpoint.outputs;
  skip_ = told_;
}

void Run::enter() {
  begin_ = now_;
  gains_begin_.clear();
  for (const auto& load : loads_) {
    gains_begin_.push_back(load->memory);
    load->enter(k_);
  }
  const double until = last() ? std::clamp(part_at(times_.back()), least_window, 1.0) : 1.0;
  for (std::size_t b = 0; b < bars_.size(); ++b) {
    junctions_[b].faces.back().arriving = arriving(b, true, until);
    junctions_[b + 1].faces.front().arriving = arriving(b, false, until);
  }
  for (Junction& junction : junctions_) {
    junction.enter(k_);
    // Waves that are only carried and sent back grow no larger.
    if (k_ == 0 || !loads_.empty() || junctions_.size() > 2 || junction.driven()) {
      const double bound = junction.bound();
      if (!std::isfinite(bound)) throw not_finite();
      now_.velocity_scale = std::max(now_.velocity_scale, bound);
    }
    now_.place_scale = std::max(now_.place_scale, junction.farthest());
  }
  std::size_t coefficients = 0;
  for (Junction& junction : junctions_) {
    junction.answer(until, {now_.place_scale + window_ * now_.velocity_scale, now_.velocity_scale});
    for (const Junction::Face& face : junction.faces) {
      now_.error += face.sent.left_out();
      coefficients += face.sent.coefficients();
    }
  }
  largest_ = std::max(largest_, coefficients);
  merge_turns();
}

const Piecewise* Run::arriving(std::size_t bar, bool at_left, double until) {
  const Piecewise& sent = (at_left ? lines_[bar].leftward : lines_[bar].rightward).arriving();
  if (loads_.empty()) return &sent;
  const Piecewise& gain = at_left ? loads_[bar]->arriving_left() : loads_[bar]->arriving_right();
  Piecewise& sum = at_left ? gained_[bar].at_left : gained_[bar].at_right;
  combine(sent, 1.0, gain, 1.0, sum);
  if (observers_.energy && !loads_[bar]->steady()) now_.work += arrived_work(bar, sent, gain, until);
  return &sum;
}

void Run::leave() {
  constexpr double of_time = 1e-8;  // a longer piece is no rounding of a time
  const double tolerance = 8.0 * rounding * now_.velocity_scale, negligible = 64.0 * rounding * now_.velocity_scale;
  for (std::size_t b = 0; b < bars_.size(); ++b)
    for (const bool rightward : {true, false}) {
      Piecewise& sent = rightward ? junctions_[b].faces.back().sent : junctions_[b + 1].faces.front().sent;
      std::size_t& simplified = lines_[b].simplified[rightward ? 0 : 1];
      carried_ += static_cast<double>(sent.size());
      if (sent.size() > 2 * simplified + 8) {
        now_.error += simplify(sent, tolerance, negligible, of_time, scratch_) + sent.left_out();
        simplified = sent.size();
        if (simplified > method_.most_pieces)
          throw StepFailure(
              Failure::detail,
              fmt::format(
                  "{} contact changes{} have broken the waves into more than {} pieces, and each passage breaks "
                  "them further: there is no end of the detail that the exact motion has",
                  statistics_.events, bars_.size() > 1 ? " and the bars' interfaces" : "", method_.most_pieces));
      }
      (rightward ? lines_[b].rightward : lines_[b].leftward).leave(sent);
    }
}

void Run::merge_turns() {
  events_.clear();
  for (std::size_t j = 0; j < junctions_.size(); ++j)
    for (const Junction::Turn& turn : junctions_[j].turns()) events_.push_back({turn, j});
  std::ranges::stable_sort(events_, {}, [](const Told& event) { return event.turn.s; });
  told_ = 0;
}

std::optional<PartEnd> Run::tell_window() {
  told_ = std::exchange(skip_, 0);
  const double end = last() ? times_.back() : std::min(time_at(1.0), times_.back());
  if (k_ == 0 && next_output_ == 0) tell_events(times_.front(), true);
  for (;;) {
    const bool output = next_output_ < times_.size() && times_[next_output_] <= end;
    double stop = output ? times_[next_output_] : end;
    if (const auto due = schedule_.next(); due && *due > t_ && *due < stop) stop = *due;
    const bool at_output = output && stop == times_[next_output_];
    tell_events(stop, false);  // an output tells the side before an event
    if (at_output) tell_output();
    const bool advanced = stop > t_;
    t_ = stop;
    if (stop == end && !output) tell_events(std::numeric_limits<double>::infinity(), true);
    if (advanced) {
      if (!notifier_.progress(t_)) return reached();
      if (t_ < times_.back() && schedule_.due(t_)) return Checkpoint{t_, next_output_, reached(), archived(*this)};
    }
    if (!at_output && stop == end) {
      ++statistics_.steps;
      return std::nullopt;
    }
  }
}

void Run::tell_events(double t, bool and_at) {
  const auto due = [&](double time) { return and_at ? time <= t : time < t; };
  while (told_ < events_.size() && due(time_of(events_[told_]))) tell(events_[told_++]);
}

void Run::tell(const Told& event) {
  ++statistics_.events;
  if (!observers_.event && !statistics_.account) return;
  const Junction::Link& link = junctions_[event.junction].links()[event.turn.link];
  const bool at_left = event.junction == 0;
  Event told{time_of(event),
             link.joint > 0 ? Where::joint
             : at_left      ? Where::left
                            : Where::right,
             link.joint > 0 ? link.joint
             : at_left      ? 0
                            : mesh_.elements,
             event.turn.change, event.turn.velocity};
  if (statistics_.account) {
    told.impulse = junctions_[event.junction].sign(event.turn.link) * event.turn.impulse;
    if (told.change == Change::opening) told.peak = peak_of(event.junction, event.turn.link, event.turn.peak);
    statistics_.account->count(told);
  }
  notifier_.told(told);
}

std::vector<Field> Run::fields(double s, double t) {
  std::vector<Field> all;
  for (std::size_t b = 0; b < bars_.size(); ++b) {
    LoadGain* load = loads_.empty() ? nullptr : loads_[b].get();
    if (load) {
      load->look(s);
      gains_begin_[b].looked_at = load->memory.looked_at;
    }
    const Junction &left = junctions_[b], &right = junctions_[b + 1];
    all.emplace_back(Field::Sent{lines_[b].rightward, sent_right(b)}, Field::Sent{lines_[b].leftward, sent_left(b)},
                     load ? &load->rightward() : nullptr, load ? &load->leftward() : nullptr, s,
                     left.displacement_at(left.faces.back().body, s, t),
                     right.displacement_at(right.faces.front().body, s, t), bars_[b].transit());
  }
  return all;
}

void Run::tell_output() {
  const double t = times_[next_output_++];
  if (!observers_.snapshot) return;
  const double s = std::clamp(part_at(t), 0.0, sent_right(0).end());
  std::vector<Field> now = fields(s, t);
  for (std::size_t b = 0; b < bars_.size(); ++b) {
    const viscobar::Piece& piece = pieces_[bars_[b].member];
    for (std::size_t i = 0; i < piece.mesh.nodes(); ++i) {
      const double place = piece.mesh.node(i) / piece.mesh.length;
      u_[piece.first + i] = now[b].displacement(place);
      v_[piece.first + i] = now[b].velocity(place);
    }
  }
  joint_forces_.clear();
  Snapshot snapshot{t, u_, v_};
  for (std::size_t j = 0; j < junctions_.size(); ++j) {
    const Junction& junction = junctions_[j];
    for (const BodyPlace& place : places_[j]) {
      const std::size_t node = place.right ? pieces_[place.member].last() : pieces_[place.member].first;
      u_[node] = junction.displacement_at(place.body, s, t);
      v_[node] = junction.velocity_at(place.body, s, t);
      now_.place_scale = std::max(now_.place_scale, std::abs(u_[node]));
    }
    for (std::size_t l = 0; l < junction.links().size(); ++l)
      if (const Junction::Link& link = junction.links()[l]; link.joint > 0)
        joint_forces_.push_back(junction.force_at(l, s));
      else if (link.kind != Junction::Kind::spring)
        (j == 0 ? snapshot.reaction_left : snapshot.reaction_right) = junction.sign(l) * junction.force_at(l, s);
  }
  snapshot.joint_forces = joint_forces_;
  if (observers_.energy) snapshot.energy = energy_at(s, now);
  notifier_.snapshot(snapshot);
}

}  // namespace viscobar::characteristics

namespace viscobar {

namespace {

// Work of a look ahead: a few tenths of a second.
constexpr std::size_t pieces_awaited = 10'000;
constexpr double work_awaited = 1e6;  // in pieces that are carried through a window

void require(const Scene& scene, std::span<const double> times, const Characteristics& method) {
  require_times(times);
  if (const auto why = refusal(scene, times.back() - times.front(), method)) throw Unfit("characteristics", *why);
}

}  // namespace

Statistics integrate(const Scene& scene, const Mesh& mesh, const std::optional<Checkpoint>& from,
                     std::span<const double> times, const Characteristics& method, const Observers& observers) {
  refuse_directions("characteristics", observers);
  require(scene, times, method);
  const StartingPoint start = from ? StartingPoint(*from) : StartingPoint(State{});
  return run_in_parts(start, times, observers, [&](const StartingPoint& begin) {
    return characteristics::Run(scene, mesh, std::get_if<Checkpoint>(&begin), times, method, observers)();
  });
}

std::optional<double> roughens(const Scene& scene, double end) {
  const double times[] = {0.0, end};
  const Characteristics method{.most_pieces = pieces_awaited};
  const Observers nobody;
  require(scene, times, method);
  try {
    characteristics::Run(scene, Mesh{scene.bar.length, 1}, nullptr, times, method, nobody, work_awaited)();
  } catch (const IntegrationError& error) {
    if (error.failure != Failure::detail || error.statistics.events == 0) throw;
    return error.statistics.reached_time;
  }
  return std::nullopt;
}

double evaluations_of_output(const Scene& scene, double end) {
  if (!scene.load || !std::holds_alternative<GeneralLoad>(*scene.load)) return 0.0;
  const double times[] = {0.0, std::min(end, 0.5 * scene.bar.transit())};
  const Characteristics method{.most_pieces = pieces_awaited};
  Observers looking;
  looking.energy = true;
  require(scene, times, method);
  const PartEnd done =
      characteristics::Run(scene, Mesh{scene.bar.length, 1}, nullptr, times, method, looking, work_awaited)();
  return static_cast<double>(std::get<Statistics>(done).load_evaluations);
}

}  // namespace viscobar
