// What the lints say of a benchmark's runs: each once, with its worst run.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "compiler/checks/lints.h"
#include "compiler/evaluate/configuration.h"
#include "compiler/plan/plan.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// Not for several threads.
class LintFindings {
 public:
  /// `benchmark`: where its name stands, for what no setting is to blame for.
  LintFindings(dsl::Span benchmark, dsl::Diagnostics& diagnostics)
      : benchmark_(benchmark), diagnostics_(diagnostics) {}

  /// The scene at the chosen point of `configuration`, which is run so many times.
  void Add(evaluate::Configuration& configuration, const plan::Scene& scene, std::size_t runs);
  /// As warnings, of a plan of so many runs, of which `looked_at` were added.
  void Report(std::size_t looked_at, std::size_t runs) const;

 private:
  struct Finding {
    LintNumber worst;
    dsl::Span span;  ///< of what makes the worst number
    std::size_t runs = 0, bad_runs = 0;
  };
  dsl::Span SpanOf(evaluate::Configuration& configuration, const std::string& group,
                   Lint lint) const;

  dsl::Span benchmark_;
  dsl::Diagnostics& diagnostics_;
  std::map<Lint, Finding> findings_;
};

}  // namespace cdb::checks
