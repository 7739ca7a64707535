#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "io/contact_account.hpp"
#include "io/sealed_summary.hpp"
#include "viscobar/analysis/case.hpp"
#include "viscobar/io/record_run.hpp"

namespace viscobar {

/// Contact over a run: an account of each end with an obstacle, counts for a span obstacle.
struct ContactSummary {
  struct Span {
    std::size_t closings = 0, openings = 0;
    static void members(auto& span, auto&& each) { each(span.closings, span.openings); }
  };
  std::optional<ContactAccount> left, right;
  std::optional<Span> span;

  explicit ContactSummary(const Scene& scene);
  void add(const Snapshot& snapshot);
  void add(const Event& event);
  /// At the end of a run, what its method knows without output times.
  void know(const Statistics& done);

  static void members(auto& contact, auto&& each) { each(contact.left, contact.right, contact.span); }
};

/// summary.json: what was run, what it cost, what came out, and the checksums of the other files. Numbers that a run
/// could not tell are null.
std::string summary_json(const SceneFile& scene, const BarSystem& system, const Outcome& outcome,
                         const ContactSummary& contact, const FileChecksums& files);

}  // namespace viscobar
