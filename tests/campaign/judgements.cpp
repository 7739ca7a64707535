#include "campaign/judgements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "campaign/draw.hpp"
#include "input/described_scene.hpp"
#include "report/judge/judge_request.hpp"
#include "studies/column_reader.hpp"
#include "viscobar/case/recording.hpp"

namespace viscobar::campaign {

namespace {

using Column = TheirSolution::Column;

// Sampled, with seven digits: by scheme (2.8) on a mass whose ends do not bounce. A bar without viscosity is solved by
// its characteristics, since waves on a mesh make a scheme touch once more, which the bar does not.
TheirSolution solution(const SceneFile& scene, std::size_t elements, double viscosity, bool energy) {
  Case run = scene.run;
  run.automatic = false;
  run.method = run.scene.bar.viscosity > 0.0 ? MethodName::fully_discrete : MethodName::characteristics;
  run.mass = Mass::redistributed;
  run.elements = elements;
  run.scene.bar.viscosity *= viscosity;
  const Bar& bar = run.scene.bar;
  run.step = bar.length / static_cast<double>(elements) * std::sqrt(bar.density / bar.modulus) / 4.0;
  const Recording made = record(run);
  TheirSolution theirs{"scheme", made.times, {}, {}, made.events};
  std::vector<std::string> names = {"u_left", "v_left", "u_right"};
  names.push_back(fmt::format("u@{}", 0.4 * bar.length));
  if (is_obstacle(run.scene.left)) names.emplace_back("reaction_left");
  if (is_obstacle(run.scene.right)) names.emplace_back("reaction_right");
  if (energy) names.emplace_back("v_right");
  for (const double part : {0.25, 0.5, 0.75})
    for (const char* of : {"u", "v"})
      if (energy) names.push_back(fmt::format("{}@{}", of, part * bar.length));
  const BarSystem system = resolve(run).system();
  for (const std::string& name : names) {
    const auto [column, place] = *trace_column(name);
    const ColumnReader read(column, place, system, run.scene);
    Column& of = theirs.columns.emplace_back(Column{name, {}});
    for (std::size_t k = 0; k < made.times.size(); ++k) {
      const struct {
        std::span<const double> u, v;
        double reaction_left, reaction_right;
      } at{made.displacement(k), made.velocity(k), made.reaction_left[k], made.reaction_right[k]};
      of.values.push_back(std::stod(fmt::format("{:.7g}", read(at))));
    }
  }
  return theirs;
}

// The distance that the judge takes of a column: the largest difference of displacements, the mean of all else.
double distance(const Column& one, const Column& other) {
  double largest = 0.0, sum = 0.0;
  for (std::size_t k = 0; k < one.values.size(); ++k) {
    const double d = std::abs(one.values[k] - other.values[k]);
    largest = std::max(largest, d), sum += d;
  }
  return one.name.starts_with("u") ? largest : sum / static_cast<double>(one.values.size());
}

double size_of(const Column& column) {
  double largest = 0.0;
  for (const double value : column.values) largest = std::max(largest, std::abs(value));
  return largest;
}

// Kinetic and elastic energy of the P1 function through five places, at each time.
std::vector<double> energies(const TheirSolution& theirs, const Bar& bar) {
  const auto values = [&](const char* of, int part) -> const std::vector<double>& {
    const std::string name = part == 0   ? fmt::format("{}_left", of)
                             : part == 4 ? fmt::format("{}_right", of)
                                         : fmt::format("{}@{}", of, 0.25 * part * bar.length);
    return std::ranges::find(theirs.columns, name, &Column::name)->values;
  };
  const double h = bar.length / 4;
  std::vector<double> all(theirs.times.size(), 0.0);
  for (int part = 0; part < 4; ++part) {
    const std::vector<double>&u = values("u", part), &v = values("v", part), &w = values("u", part + 1),
          &z = values("v", part + 1);
    for (std::size_t k = 0; k < all.size(); ++k)
      all[k] += 0.5 * bar.density * h / 3 * (v[k] * v[k] + v[k] * z[k] + z[k] * z[k]) +
                0.5 * bar.modulus / h * (w[k] - u[k]) * (w[k] - u[k]);
  }
  return all;
}

double drift(const std::vector<double>& one, const std::vector<double>& other) {
  double most = 0.0;
  for (std::size_t k = 0; k < one.size(); ++k) most = std::max(most, std::abs(one[k] - other[k]));
  return most;
}

struct Span {
  std::size_t begin = 0, end = 0;  // samples
  std::size_t size() const { return end - begin; }
};

// The longest run of samples with a reaction, or without, those of the other kind left out that are fewer than `merge`.
Span longest(const Column& reaction, bool contact, std::size_t merge) {
  Span best, now;
  for (std::size_t k = 0; k < reaction.values.size(); ++k) {
    if ((reaction.values[k] != 0.0) != contact) continue;
    now = k < now.end + merge && now.size() > 0 ? Span{now.begin, k + 1} : Span{k, k + 1};
    if (now.size() > best.size()) best = now;
  }
  return best;
}

constexpr std::size_t shift = 4;  // samples

}  // namespace

std::string judged_scene(std::uint64_t seed, std::size_t index) {
  Draw draw(seed, index);
  const double length = draw.decades(0.3, 3.0), density = draw.decades(0.3, 3.0), modulus = draw.decades(0.1, 10.0);
  const double c = std::sqrt(modulus / density), transit = length / c;
  const double viscosity = draw.chance(0.3) ? 0.0 : draw.decades(3e-3, 1.0) * modulus * transit;
  const double strain = draw.decades(1e-3, 1e-1), u = strain * length, v = strain * c;
  const double end = transit * draw.between(4.0, 10.0);
  const bool falls = draw.chance(0.5), walled = !falls && draw.chance(0.5);
  return fmt::format(
      "[bar]\nlength = {}\ndensity = {}\nmodulus = {}\nviscosity = {}\n[left]\nkind = \"obstacle\"\ngap = {}\n{}"
      "[initial]\nvelocity = \"{}*(1+{}*x)\"\n{}[time]\nend = {}\n[mesh]\nelements = 100\n[output]\nevery = {}\n",
      length, density, modulus, viscosity, u * draw.between(0.1, 1.0),
      walled ? fmt::format("[right]\nkind = \"obstacle\"\nside = \"above\"\ngap = {}\n", u * draw.between(0.1, 1.0))
             : "",
      -v, draw.between(-0.3, 0.3) / length,
      falls ? fmt::format("[load]\ndensity = {}\n", -density * v / transit * draw.between(0.3, 1.0)) : "", end,
      end / draw.one_of({400, 600, 800}));
}

JudgedSample run_judgement(std::uint64_t seed, std::size_t index) {
  constexpr std::size_t elements = 240;
  const std::string text = judged_scene(seed, index);
  const SceneFile scene = parse_scene_with(text, "scene", of_the_bar_itself());
  Draw draw(seed + 1, index);
  constexpr const char* ways[] = {
      "a contact dropped", "a contact added", "a time shift",       "1 % of viscosity",   "a sign",
      "a reaction scaled", "noise",           "a place confounded", "energy that drifts", "a late contact"};
  const std::size_t way = index / 2 % std::size(ways);
  const bool spoils = index % 2 == 1, with_energy = way == 8;
  TheirSolution theirs = solution(scene, elements, 1.0, with_energy),
                coarse = solution(scene, elements / 2, 1.0, with_energy);
  const TheirSolution coarsest = solution(scene, elements / 4, 1.0, with_energy);
  // Contacts by their reactions, of some of the sound ones by displacements alone, or by their changes.
  const std::size_t shown = spoils ? 0 : index / 2 % 3;
  for (TheirSolution* one : {&theirs, &coarse}) {
    if (shown != 2) one->changes.reset();
    if (shown == 1) std::erase_if(one->columns, [](const Column& of) { return of.name.starts_with("reaction"); });
  }
  const TheirSolution sound = theirs;
  JudgedSample judged{Verdict::right, spoils ? ways[way] : "nothing", ""};
  const auto refused = [&](const std::string& why) { return JudgedSample{Verdict::refused, judged.spoiled, why}; };
  const auto column = [&](const char* name) -> Column& {
    return *std::ranges::find(theirs.columns, name, &Column::name);
  };
  if (spoils) {
    Column &u = column("u_left"), &reaction = column("reaction_left");
    const Span contact = longest(reaction, true, 10), flight = longest(reaction, false, 1);
    switch (way) {
      case 0:
        if (contact.size() < 15) return refused("no contact of 15 samples");
        for (std::size_t k = contact.begin; k < contact.end; ++k) reaction.values[k] = 0.0;
        break;
      case 1: {
        const std::size_t at = flight.begin + flight.size() / 2;
        if (flight.size() < 15) return refused("no flight of 15 samples");
        for (std::size_t k = at; k < at + 3; ++k) reaction.values[k] = size_of(reaction);
        break;
      }
      case 2:
        for (Column& one : theirs.columns) {
          std::rotate(one.values.begin(), one.values.end() - shift, one.values.end());
          std::fill_n(one.values.begin(), shift, std::nan(""));
        }
        break;
      case 3:
        theirs = solution(scene, elements, 1.01, false);
        theirs.changes.reset();
        break;
      case 4:
        for (double& value : u.values) value = -value;
        break;
      case 5:
        for (double& value : reaction.values) value *= 1.5;
        break;
      case 6: {
        const double deviation = 0.03 * size_of(u);
        for (double& value : u.values) value += deviation * draw.normal();
        break;
      }
      case 7: u.values.swap(column("u_right").values); break;
      case 8:
        for (Column& one : theirs.columns)
          for (std::size_t k = 0; k < theirs.times.size() && !one.name.starts_with("reaction"); ++k)
            one.values[k] *= 1.0 + 0.1 * theirs.times[k] / theirs.times.back();
        break;
      default: {
        const auto begin = reaction.values.begin() + static_cast<std::ptrdiff_t>(contact.begin),
                   end = reaction.values.begin() + static_cast<std::ptrdiff_t>(contact.end);
        if (contact.size() < 15 || contact.end + 2 * shift > reaction.values.size() ||
            std::any_of(end, end + 2 * shift, [](double value) { return value != 0.0; }))
          return refused("no contact of 15 samples before a flight");
        std::rotate(begin, end, end + shift);
      }
    }
  }

  JudgeStudy study;
  study.scene = scene.run;
  study.request = *scene.accuracy;
  study.solutions = {theirs, coarse};
  study.most_seconds = 20.0;
  study.threads = 1;
  const JudgeResult result = judge(study);
  const JudgedSolution& told = result.solutions.front();

  // The columns that are further from the bar than the solution's own error and ours put them. Of order 1, the error of
  // the finer mesh is as large as the difference, but for where in a step the bar touches, which may make one
  // difference small by chance: twice the larger of two. What jumps may be on the other side of its jump at a sample or
  // two beside each change.
  std::string far;
  bool expected = false;  // of a column, by what was done to it
  const double changes = 2.0 * static_cast<double>(told.contacts.size()),
               rows = static_cast<double>(theirs.times.size());
  for (std::size_t k = 0; k < theirs.columns.size(); ++k) {
    const JudgedColumn& one = told.columns[k];
    const Column& coarser = coarse.columns[k];
    const Column& first = *std::ranges::find(coarsest.columns, one.name, &Column::name);
    const double error = std::max(2.0 * distance(sound.columns[k], coarser), distance(coarser, first)) +
                         one.own_distance().value_or(0.0) +
                         (1e-6 + (one.jumps() ? 2.0 * changes / rows : 0.0)) * one.size;
    const double moved = distance(theirs.columns[k], sound.columns[k]);
    if (one.distance() > error)
      far += fmt::format("{} is off by {:.3g}, not {:.3g}; ", one.name, one.distance(), error);
    expected = expected || moved > 2.0 * error || (way == 2 && one.size > 0.0) || way == 9;
  }
  bool drift_told = true;  // as it is, to the solution's error
  if (with_energy) {
    const Bar& bar = scene.run.scene.bar;
    const std::vector<double> of_sound = energies(sound, bar), of_coarse = energies(coarse, bar);
    const double error = std::max(2.0 * drift(of_sound, of_coarse), drift(of_coarse, energies(coarsest, bar))) +
                         1e-5 * *std::ranges::max_element(of_sound);
    const double made = drift(energies(theirs, bar), of_sound);
    expected = expected && made > 2.0 * error;
    drift_told = told.energy_drift && std::abs(std::abs(*told.energy_drift) - made) <= error;
    if (!drift_told)
      far += fmt::format("energy drifts by {:.3g}, told {:.3g}, not {:.3g}; ", made, told.energy_drift.value_or(0.0),
                         error);
  }
  const auto latest = [](const JudgedSolution& of) {
    double late = 0.0;
    for (const JudgedContact& one : of.contacts)
      if (const double delay = one.delay().value_or(0.0); std::abs(delay) > std::abs(late)) late = delay;
    return late;
  };
  const double late = latest(told), sample = theirs.times[1] - theirs.times[0];
  const std::size_t missed = told.count(ContactVerdict::missed), made_up = told.count(ContactVerdict::made_up);
  judged.said = fmt::format("{}missed {}, made up {}, untold {}, late by {:.3g}, of samples {:.3g}", far, missed,
                            made_up, told.count(ContactVerdict::untold), late, sample);
  // At order 1, contacts of the coarser solution are late by twice as much.
  const bool sound_contacts =
      missed == 0 && made_up == 0 && std::abs(late) <= 2.0 * sample + std::abs(latest(result.solutions.back()));
  bool right = far.empty() && sound_contacts;
  if (spoils) {
    if (way >= 2 && !expected) return refused("changes the motion by less than the solution's error");
    right = way == 0   ? missed == 1 && made_up == 0
            : way == 1 ? made_up == 1 && missed == 0
            : way == 2 ? !far.empty() && missed == 0 && made_up == 0 &&
                             std::abs(late - static_cast<double>(shift) * sample) <= 2.0 * sample
            : way == 9 ? missed == 0 && made_up == 0 &&
                             std::abs(late - static_cast<double>(shift) * sample) <=
                                 2.0 * sample + std::abs(latest(result.solutions.back()))
            : way == 8 ? !far.empty() && drift_told
            : way == 3 ? !far.empty()  // and a contact that the bar comes to slowly is late by much
                       : !far.empty() && sound_contacts;
  }
  judged.verdict = right ? Verdict::right : Verdict::false_;
  return judged;
}

}  // namespace viscobar::campaign
