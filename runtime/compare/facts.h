// Compares the figures of two results files other than times: final states, verdicts, errors,
// missed pairs and memory (`cdb compare`). They are the same in every repeat, so they are compared
// exactly, without statistics. Only the peak of the resident memory varies: it has changed if the
// ranges of its repeats do not overlap.
#pragma once

#include <string>
#include <vector>

#include "runtime/compare/match.h"
#include "runtime/figures/numbers.h"

namespace cdb::compare {

/// Whether the motion is the same to the last bit; for detectors on traces, whether they report the
/// same pairs in the last cycle.
struct StateComparison {
  bool of_pairs = false;  ///< compares pairs: every run is on a trace
  std::size_t same = 0;
  std::vector<std::size_t> other;      ///< matched points with different final states
  std::vector<std::size_t> unsettled;  ///< points whose repeats differ within one file: not
                                       ///< repeatable
  std::size_t unknown = 0;             ///< points with a run without a final state: it failed
};

enum class Direction { kBetter, kWorse, kOther };

/// A value that differs at a matched point. For verdicts, numbers are NaN.
struct FactChange {
  std::size_t point;
  Direction direction;
  double a = figures::kNone, b = figures::kNone;
  std::string text_a, text_b;  ///< with units
  /// The relative change of the values; infinite from 0, or if one is missing.
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
  std::size_t points = 0;           ///< number compared
  std::vector<FactChange> changes;  ///< the largest first

  std::size_t Count(Direction direction) const;
  /// True if something is worse: a verdict or a count of misses at all, other values by more than
  /// `margin`.
  bool IsWorse(double margin) const;
};

StateComparison CompareStates(const ComparedFile& a, const ComparedFile& b,
                              const PointMatch& match);
/// Facts that both files have, verdicts first.
std::vector<FactComparison> CompareFacts(const ComparedFile& a, const ComparedFile& b,
                                         const PointMatch& match);

}  // namespace cdb::compare
