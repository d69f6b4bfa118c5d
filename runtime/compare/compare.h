// Two results files of the same benchmark side by side: what became faster or slower, less true,
// less stable (`cdb compare`). Numbers only; compare_text.h and compare_json.h print them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "runtime/compare/facts.h"
#include "runtime/compare/match.h"
#include "runtime/compare/setup.h"
#include "runtime/compare/times.h"

namespace cdb::compare {

struct CompareOptions {
  std::vector<std::string> select = {};      ///< `axis=value`
  std::optional<measure::Phase> phase = {};  ///< that alone
  /// What is worse by more is a failure; what may differ by less is the same.
  double margin = 0.05;
  /// Groups are judged relative to the median of all groups.
  bool is_relative = false;
  bool lists_all = false;  ///< every point, also where nothing changed
};

/// `b` relative to `a`. The files must outlive it.
struct Comparison {
  const ComparedFile *a, *b;
  PointMatch match;
  SetupComparison setup;
  StateComparison states;
  std::vector<FactComparison> facts;
  TimeComparison times;
};
/// Throws StoreError for unlike scenes, points that do not match, and if options ask for what the
/// files do not have. Not judged yet.
Comparison Compare(const ComparedFile& a, const ComparedFile& b, const CompareOptions& options);

/// Judges the times of all comparisons of a command as one family of tests.
void JudgeAll(const std::vector<Comparison*>& comparisons, const CompareOptions& options);

/// The judgement that counts.
const JudgedChange& JudgementOf(const TimeChange& change, const CompareOptions& options);
/// Groups, facts and points that are slower or worse by more than the margin: `sap step`.
std::vector<std::string> WorseThings(const Comparison& comparison, const CompareOptions& options);
bool IsWorse(const Comparison& comparison, const CompareOptions& options);

}  // namespace cdb::compare
