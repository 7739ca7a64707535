#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "studies/run_limits.hpp"
#include "viscobar/case/accuracy.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar::accuracy {

/// Elements of the bar of a case that has the fewest: of a chain a mesh is refined in all of them by one factor.
std::size_t fewest_in_a_bar(const Case& run);
/// The case on a mesh of its scene, whose elements are those of its bars: their multiples have all nodes of it.
Case on_mesh(Case run, const Mesh& mesh);
inline Case on_its_mesh(const Case& run) { return on_mesh(run, run.mesh()); }
/// Puts a chain on the coarsest of the meshes, and tells the elements of each, all bars refined by one factor. Absent:
/// a mesh is no multiple of the coarsest, and nothing is changed. One bar has the elements asked for.
std::optional<std::vector<std::size_t>> refine_by_one_factor(Case& run, std::vector<std::size_t> meshes);

/// Data of a run for all goals: the field at some nodes and times, the ends, the contacts.
struct Sample {
  struct Range {
    std::size_t begin, end;
  };
  std::vector<double> x;               ///< places that are kept
  std::vector<Range> members;          ///< places of the bar, or of each of a chain; two have one where they are bonded
  std::vector<double> times;           ///< K
  std::vector<double> u;               ///< of them, K times, row by row
  std::vector<Event> events;           ///< contact changes
  std::vector<double> impulse;         ///< of both ends, and of the joints of a chain
  std::vector<double> peak;            ///< max |R| of them
  std::vector<double> speed;           ///< max |v| of both ends at the output times, of joints that of its sides apart
  std::vector<double> end_velocities;  ///< of both ends, 2 K
  Statistics statistics;               ///< of the run
  double end = 0.0;                    ///< T

  /// The place to the right of joint k of a chain, where it is not bonded; else 0.
  std::size_t right_of(std::size_t joint) const {
    return members[joint].begin == members[joint - 1].end ? members[joint].begin : 0;
  }
  std::size_t rows() const { return x.empty() ? 0 : u.size() / x.size(); }
  const double* row(std::size_t k) const { return u.data() + k * x.size(); }
};

/// The times at which errors are looked at, whatever the output times of a run are: the ends of 250 equal parts of
/// it.
std::vector<double> times_of_errors(double end);

/// Collects a sample while a run goes on. Of a run with many nodes it keeps each 2^k-th one, so that those of a mesh
/// with half as many elements are among those of the finer one.
class Probe {
 public:
  /// `times`: how many there will be.
  Probe(const Case& run, std::size_t times);

  void add(const Snapshot& snapshot);
  void add(const Event& event) { sample_.events.push_back(event); }
  /// The sample, of a run that is over.
  Sample take(const Statistics& statistics);

 private:
  std::size_t node_stride_ = 1;
  Sample sample_;
};

/// Runs a case in memory; peaks of reactions are 0 unless they are asked for. @throws as simulate_within()
Sample sample_of(const Case& run, std::span<const double> times, const RunLimits& limits = {}, bool peaks = false);

/// The largest value of the goal.
double largest(const Sample& sample, Goal of);

/// Contact changes at an end that matter to an error of `height`, a displacement: without flights lower than it, as far
/// as the speed at their end and the output times within them show, and contacts whose impulse moves the bar by less,
/// J / (A sqrt(rho E)). With `duration` in place of it, without flights and contacts that last less.
struct Resolution {
  double height = 0.0;
  double duration = 0.0;
  double impedance = 1.0;  ///< A sqrt(rho E)
};
/// Times of the changes that matter, closings and openings in turns; `closed` is whether the first one closes.
struct Changes {
  bool first_closes = true;
  std::vector<double> times;
};
Changes changes_that_matter(const Sample& sample, Where end, const Resolution& resolution, std::size_t joint = 0);

/// True if the goal is a field over time; else it is a few numbers of the run.
bool is_field(Goal of);

/// True if the same contacts change in the same order at each end, among the changes that matter.
struct SameChanges {
  bool same = true;
  std::size_t coarse = 0, fine = 0;  ///< changes of the two
};
SameChanges compare_changes(const Sample& coarse, const Sample& fine, const Resolution& resolution);

/// How far two runs are apart, in the unit of the goal: at the places of the first, whose mesh is the coarser one;
/// where they are no nodes of the other, by interpolation with six of its nodes. The resolution counts for contact
/// times alone.
double difference(const Sample& coarse, const Sample& fine, Goal of, const Resolution& resolution = {});

/// Cosine of the angle between two changes of a solution, from the first run to the second and from that to the third,
/// as vectors of what the goal is of, at the places of the first. 1 where one of them vanishes.
double alignment(const Sample& first, const Sample& second, const Sample& third, Goal of, const Resolution& resolution);

}  // namespace viscobar::accuracy
