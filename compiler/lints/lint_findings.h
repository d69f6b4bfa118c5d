// Findings of the lints in the runs of a benchmark: each once, with its worst run.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "compiler/configure/configuration.h"
#include "compiler/lints/lints.h"
#include "compiler/plan/plan.h"
#include "dsl/diagnostics.h"

namespace cdb::lints {

/// Not thread-safe.
class LintFindings {
 public:
  /// `benchmark`: the location of its name, for findings that no single setting causes.
  LintFindings(text::Span benchmark, dsl::Diagnostics& diagnostics)
      : benchmark_(benchmark), diagnostics_(diagnostics) {}

  /// Adds the scene at the chosen point of `configuration`, which has `runs` runs.
  void Add(configure::Configuration& configuration, const plan::Scene& scene, std::size_t runs);
  /// Reports warnings for a plan of `runs` runs, of which `looked_at` were added.
  void Report(std::size_t looked_at, std::size_t runs) const;

 private:
  struct Finding {
    LintNumber worst;
    text::Span span;  ///< of the setting that causes the worst number
    std::size_t runs = 0, bad_runs = 0;
  };
  text::Span SpanOf(configure::Configuration& configuration, const std::string& group,
                    Lint lint) const;

  text::Span benchmark_;
  dsl::Diagnostics& diagnostics_;
  std::map<Lint, Finding> findings_;
};

// Counts of runs, as text for messages.

/// `2 of 6 runs`; if not all of them were checked, `2 of the 100 runs that were looked at, of
/// 5000`.
std::string CountText(std::size_t count, std::size_t looked_at, std::size_t runs);

}  // namespace cdb::lints
