#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "viscobar/case/accuracy.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// A solution by another program.
struct TheirSolution {
  /// A quantity over time: a column of ends.csv, or of gauges.csv such as u@0.25.
  struct Column {
    std::string name;            ///< of the column
    std::vector<double> values;  ///< K, NaN where there is none
  };
  std::string label;            ///< in tables
  std::vector<double> times;    ///< K, strictly increasing, in [0, end]
  std::vector<Column> columns;  ///< one at least, or else changes
  std::optional<double> step;   ///< of their scheme
  /// Contact changes in the order of time; absent: contacts are those that the columns show.
  std::optional<std::vector<Event>> changes = {};
  std::size_t scheme = 0;  ///< solutions of one scheme with several steps show an order

  const Column* column(const std::string& name) const;  ///< nullptr where there is none
};

/// Solutions of one scene that are to be judged by the bar's own motion, with a rigid obstacle.
struct JudgeStudy {
  Case scene;  ///< sound; its method, mesh, epsilon and tolerances are chosen anew where `request` leaves them open
  AccuracyRequest request;               ///< `error` is where the search begins, a share of the largest value
  std::vector<TheirSolution> solutions;  ///< one at least
  double most_seconds = 60.0;            ///< on the clock, for our own runs
  std::size_t threads = 0;               ///< 0: one a core
  std::function<bool()> stop;            ///< asked after each step; may be empty
};

/// A quantity of one of their solutions, beside that of the bar: d(t) is theirs less ours.
///
/// Where velocities, strains, stresses and reactions jump, a shift in time is a large d however small it is. Their
/// distance is the mean |d|, that of displacements the largest.
struct JudgedColumn {
  std::string name;                 ///< of the column
  double largest = 0.0;             ///< max |d|
  double at = 0.0;                  ///< when
  double root_mean_square = 0.0;    ///< of d
  double mean = 0.0;                ///< (1/T) int |d| dt, by the trapezoidal rule between their times
  double size = 0.0;                ///< largest value of ours
  std::optional<double> own_error;  ///< largest error of ours; absent: not known of one run alone
  std::optional<double> own_mean;   ///< mean error of ours; likewise
  std::optional<double> order;      ///< power of the step that the distance shows from the next coarser solution
  std::vector<double> theirs;       ///< K, for pictures
  std::vector<double> ours;         ///< K, for pictures

  bool jumps() const { return !name.starts_with("u"); }         ///< true if the mean is its distance
  double distance() const { return jumps() ? mean : largest; }  ///< of the two
  /// Error of ours in that distance.
  std::optional<double> own_distance() const { return jumps() ? own_mean : own_error; }
  /// True if the distance is theirs and not ours; so is one of 0 where ours has no error.
  bool told_apart() const { return !own_distance() || distance() > 2.0 * *own_distance() || *own_distance() == 0.0; }
};

/// The verdict on a contact.
enum class ContactVerdict {
  found,    ///< both have it
  missed,   ///< theirs has it not
  made_up,  ///< ours has it not
  untold    ///< theirs may have it between two samples or behind the last, or ours within its own error
};
std::string_view name(ContactVerdict verdict);  ///< in words

/// A contact at an end, or under a span obstacle.
struct JudgedContact {
  Where where = Where::left;                       ///< of the obstacle
  std::optional<double> place = {};                ///< x under a span obstacle, where a u shows it; absent: anywhere
  ContactVerdict verdict = ContactVerdict::found;  ///< found, missed, ...
  std::optional<double> begin = {};                ///< start of our contact
  std::optional<double> end = {};                  ///< end of our contact
  std::optional<double> their_begin = {};          ///< start of theirs, to a sample, or as their changes say
  std::optional<double> their_end = {};            ///< end of theirs, known as well as the start
  std::size_t parts = 0;                           ///< of ours, with flights between that theirs has not
  std::size_t their_parts = 0;                     ///< of theirs likewise
  std::optional<double> own_error = {};            ///< of our times, where two of our runs have the contact

  /// How much later theirs begins; absent where not both have it.
  std::optional<double> delay() const { return one_less(their_begin, begin); }
  /// How much longer it lasts.
  std::optional<double> longer() const { return one_less(one_less(their_end, end), delay()); }

 private:
  static std::optional<double> one_less(const std::optional<double>& one, const std::optional<double>& other) {
    return one && other ? std::optional(*one - *other) : std::nullopt;
  }
};

/// One of their solutions beside the bar.
struct JudgedSolution {
  std::vector<JudgedColumn> columns;    ///< in the order of theirs
  std::vector<JudgedContact> contacts;  ///< in the order of time
  double sample = 0.0;                  ///< mean distance of their times; 0 where contact changes are given

  std::size_t count(ContactVerdict verdict) const;  ///< of contacts
  /// Largest difference of the energy, kinetic and elastic, of the P1 function through the places that have u and v,
  /// with the masses and springs of ends that are among them: theirs less ours, where there are three such places.
  std::optional<double> energy_drift;
  std::optional<double> energy_share;  ///< of the largest of ours
};

/// The result of a judgement.
struct JudgeResult {
  std::vector<JudgedSolution> solutions;  ///< in the order of the study
  Case run;                               ///< of ours, the finer one
  ErrorEstimate estimate;                 ///< of its displacements
  std::size_t runs = 0;                   ///< solutions of ours that came to their end
  std::string reason;                     ///< why the search for a better one ended
};

/// Solves the scene to smaller and smaller errors, by factors of 10, until two solutions in a row differ by less than a
/// tenth of what each of theirs differs by, or the time is up. The difference of the last two is told as our own error:
/// the coarser of them has it, and the finer is what theirs are held against.
/// @throws std::invalid_argument for columns that nobody knows, times that the scene does not have
/// @throws IntegrationError where no run of ours came to its end
JudgeResult judge(const JudgeStudy& study);

}  // namespace viscobar
