// The questions that the verdicts of a file leave open, and the objects that they concern.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/figures/points.h"
#include "runtime/results/store.h"

namespace cdb::figures {

/// The questions that the verdicts of all `cells` answer. Empty for files that do not have them.
/// Throws StoreError.
std::vector<std::string> CheckedQuestions(const results::ResultFile& file,
                                          const std::vector<Cell>& cells);

/// A question that verdicts leave open for one reason (compiler/analysis/coverage.h).
struct OpenQuestion {
  std::string question, why;  ///< `rest`; `group top is placed by at`
  std::size_t runs;
};

/// Those of `cells`, in the order in which they are found. Empty for files that do not have them.
/// Throws StoreError.
std::vector<OpenQuestion> OpenQuestions(const results::ResultFile& file,
                                        const std::vector<Cell>& cells);
/// `Not checked: rest (group top is placed by at); losses (group box has damping) in 3 of 12
/// runs.`; empty if no question is open.
std::string OpenQuestionsText(const results::ResultFile& file, const std::vector<Cell>& cells);

/// True if a run may not be called sound, as a vital question is open (QuestionInfo::is_vital).
bool LeavesVitalOpen(const results::ResultFile& file, const std::vector<Cell>& cells);

/// The number of objects of a run that can move; NaN if the file does not say.
double MovingObjectsOf(const results::ResultFile& file, const Cell& cell);
/// `439 of 2000 objects`; empty if the verdict concerns none.
std::string BadObjectsText(const results::ResultFile& file, const Cell& cell);

/// The verdict of a row that is not stable, for its table: `tunnelled, 88 of 300 objects`, or `3 of
/// 5 not stable`; empty for void rows, whose mark says it. Throws StoreError.
std::string UnsoundText(const results::ResultFile& file, const Row& row);

/// A sentence about the run in which the largest part of the objects sleeps, since a step over
/// sleepers is less work; empty if it is less than a tenth in all runs.
std::string SleepNote(const results::ResultFile& file, const std::vector<Cell>& cells);

}  // namespace cdb::figures
