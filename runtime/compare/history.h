// Results files of one benchmark in order, for example of several commits (`cdb compare a.h5 b.h5
// c.h5`).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "runtime/compare/compare.h"
#include "runtime/printers/document.h"

namespace cdb::compare {

struct BenchmarkHistory {
  std::vector<std::unique_ptr<ComparedFile>> files;  ///< two or more
  std::vector<Comparison> steps;                     ///< each file relative to the one before it
  std::vector<Comparison> to_first;  ///< the third file and later ones, relative to the first;
                                     ///< empty for two

  /// The last file relative to the first.
  const Comparison& Whole() const { return to_first.empty() ? steps[0] : to_first.back(); }
};
/// Throws StoreError as Compare does.
BenchmarkHistory MakeHistory(std::vector<std::unique_ptr<ComparedFile>> files,
                             const CompareOptions& options);
/// Judges all steps, corrected for the tests of all benchmarks together.
void JudgeHistories(std::vector<BenchmarkHistory>& benchmarks, const CompareOptions& options);

/// For several files: the differences from one to the next, then a line for each group with its
/// ratio to the first file and the steps at which it changed. `names`: of the files, or of their
/// folders.
printers::Document HistoryDocument(const std::vector<BenchmarkHistory>& benchmarks,
                                   const std::vector<std::string>& names,
                                   const CompareOptions& options);

/// A character for each value, `▁` for the least and `█` for the greatest; a blank for NaN. Values
/// within 1 % of each other are drawn at one height.
std::string Sparkline(const std::vector<double>& values);

}  // namespace cdb::compare
