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
  std::vector<Column> columns;  ///< one at least
  std::optional<double> step;   ///< of their scheme; several solutions with steps show an order

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
struct JudgedColumn {
  std::string name;                 ///< of the column
  double largest = 0.0;             ///< max |d|
  double at = 0.0;                  ///< when
  double root_mean_square = 0.0;    ///< of d
  double size = 0.0;                ///< largest value of ours
  std::optional<double> own_error;  ///< how much ours may be wrong by; absent: not known of one run alone
  std::optional<double> order;      ///< power of the step that d shows from the next coarser solution to this one
  std::vector<double> theirs;       ///< K, for pictures
  std::vector<double> ours;         ///< likewise
  /// True if d is theirs and not ours; so is a d of 0 where ours has no error.
  bool told_apart() const { return !own_error || largest > 2.0 * *own_error || *own_error == 0.0; }
};

/// A contact at an end.
struct JudgedContact {
  Where where = Where::left;          ///< of the obstacle
  std::optional<double> begin;        ///< ours; absent: they made it up
  std::optional<double> end;          ///< likewise
  std::optional<double> their_begin;  ///< to a sample; absent: they missed it
  std::optional<double> their_end;    ///< likewise
};

/// One of their solutions beside the bar.
struct JudgedSolution {
  std::vector<JudgedColumn> columns;    ///< in the order of theirs
  std::vector<JudgedContact> contacts;  ///< in the order of time
  std::size_t missed = 0;               ///< contacts of ours; one that is shorter than their samples is not missed
  std::size_t made_up = 0;              ///< contacts of theirs that ours has not
  /// Largest difference of the energy, kinetic and elastic, of the P1 function through the places that have u and v:
  /// theirs less ours, where there are three such places at least.
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
