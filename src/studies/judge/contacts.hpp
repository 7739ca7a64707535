#pragma once

#include <span>
#include <vector>

#include "viscobar/studies/judge/judge.hpp"

namespace viscobar {

/// The bar's own motion, as far as its contacts need it.
struct OwnContacts {
  std::span<const Event> changes;  ///< of the finer of our runs
  std::span<const Event> coarser;  ///< of the coarser one; empty where there is none
  /// Displacements of the ends at their times, and of both sides of each joint that is a contact.
  std::vector<std::vector<double>> ends;
  double touch = 0.0;  ///< a displacement so near to an obstacle is at it
};

/// Contacts of a solution whose columns have been judged, beside the bar's, into `judged.contacts`.
///
/// Theirs are those of their changes; else where there is a reaction, or else where u is at the obstacle. Parts that
/// meet one contact of the other are one. Contacts of a place are paired in their order so that the sum over pairs of
///
///     reach - |their begin - our begin|,      reach = 2 T / (the larger number of contacts),
///
/// is largest (match_times): one that comes late is late, and one alone is the other's whenever it comes.
void judge_contacts(JudgedSolution& judged, const TheirSolution& theirs, const Case& run, const OwnContacts& ours);

}  // namespace viscobar
