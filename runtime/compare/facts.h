// What is no time: the state that runs end in, verdicts, errors, missed pairs, memory, of two
// results files (`cdb compare`). It is the same in every repeat, so that it is compared exactly,
// without statistics; only the peak of the resident memory varies, and has changed if the ranges of
// its repeats are apart.
#pragma once

#include <string>
#include <vector>

#include "runtime/compare/match.h"
#include "runtime/terminal/numbers.h"

namespace cdb::compare {

/// Whether the physics is the same to the last bit; of detectors on traces, the pairs that they
/// list in the last cycle.
struct StateComparison {
  bool of_pairs = false;  ///< every run is on a trace
  std::size_t same = 0;
  std::vector<std::size_t> other;      ///< matched points with another last state
  std::vector<std::size_t> unsettled;  ///< those whose repeats differ in one file: not repeatable
  std::size_t unknown = 0;             ///< a run without a last state: it failed
};

enum class Direction { kBetter, kWorse, kOther };

/// A value that differs at a matched point. For verdicts, numbers are NaN.
struct FactChange {
  std::size_t point;
  Direction direction;
  double a = terminal::kNone, b = terminal::kNone;
  std::string text_a, text_b;  ///< with units
  /// Of the values; infinite from 0, or where one is missing.
  double RelativeChange() const;
};

/// One fact over all points.
struct FactComparison {
  enum class Kind {
    kVerdict,
    kError,  ///< of /accuracy
    kPairs,  ///< missed pairs and contacts
    kCount,  ///< neither better nor worse: pairs, contacts
    kMemory,
  };
  Kind kind;
  std::string name;                 ///< `energy error`
  std::size_t points = 0;           ///< compared
  std::vector<FactChange> changes;  ///< the largest first

  std::size_t Count(Direction direction) const;
  /// Something is worse: a verdict or a count of misses at all, others by more than `margin`.
  bool IsWorse(double margin) const;
};

StateComparison CompareStates(const ComparedFile& a, const ComparedFile& b,
                              const PointMatch& match);
/// Facts that both files have, verdicts first.
std::vector<FactComparison> CompareFacts(const ComparedFile& a, const ComparedFile& b,
                                         const PointMatch& match);

}  // namespace cdb::compare
