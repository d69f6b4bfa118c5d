// What the lints say of a benchmark's runs: each once, with its worst run.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "compiler/configure/configuration.h"
#include "compiler/lints/lints.h"
#include "compiler/plan/plan.h"
#include "dsl/diagnostics.h"

namespace cdb::lints {

/// Not for several threads.
class LintFindings {
 public:
  /// `benchmark`: where its name stands, for what no setting is to blame for.
  LintFindings(text::Span benchmark, dsl::Diagnostics& diagnostics)
      : benchmark_(benchmark), diagnostics_(diagnostics) {}

  /// The scene at the chosen point of `configuration`, which is run so many times.
  void Add(configure::Configuration& configuration, const plan::Scene& scene, std::size_t runs);
  /// As warnings, of a plan of so many runs, of which `looked_at` were added.
  void Report(std::size_t looked_at, std::size_t runs) const;

 private:
  struct Finding {
    LintNumber worst;
    text::Span span;  ///< of what makes the worst number
    std::size_t runs = 0, bad_runs = 0;
  };
  text::Span SpanOf(configure::Configuration& configuration, const std::string& group,
                    Lint lint) const;

  text::Span benchmark_;
  dsl::Diagnostics& diagnostics_;
  std::map<Lint, Finding> findings_;
};

}  // namespace cdb::lints
