// Compares two results files of one benchmark: speed, accuracy and stability (`cdb compare`).
// Numbers only; text.h and json.h print them.
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
  std::optional<measure::Phase> phase = {};  ///< only this phase
  /// A value that is worse by more than this is a failure; values that differ by less are the same.
  double margin = 0.05;
  /// Groups are judged relative to the median of all groups.
  bool is_relative = false;
  bool lists_all = false;  ///< list every point, also those that did not change
};

/// File `b` relative to file `a`, both of which must outlive it.
struct Comparison {
  const ComparedFile *a, *b;
  PointMatch match;
  SetupComparison setup;
  StateComparison states;
  std::vector<FactComparison> facts;
  TimeComparison times;
};
/// Throws StoreError for unlike scenes, for points that do not match, and if the options request
/// data that the files lack. The changes are not judged yet.
Comparison Compare(const ComparedFile& a, const ComparedFile& b, const CompareOptions& options);

/// Judges the times of all comparisons of a command as one family of tests.
void JudgeAll(const std::vector<Comparison*>& comparisons, const CompareOptions& options);

/// The judgement that the options select.
const JudgedChange& JudgementOf(const TimeChange& change, const CompareOptions& options);
/// Groups, facts and points that are slower or worse by more than the margin: `sap step`.
std::vector<std::string> WorseThings(const Comparison& comparison, const CompareOptions& options);
bool IsWorse(const Comparison& comparison, const CompareOptions& options);

}  // namespace cdb::compare
