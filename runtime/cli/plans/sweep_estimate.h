// Estimates the cost of a sweep from a few of its runs, which are executed for a few cycles.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/grid/grid.h"
#include "runtime/sweep/process/stop.h"

namespace cdb::plans {

/// A run that was executed for a few cycles.
struct SampledRun {
  double seconds = 0;   ///< predicted for all of its cycles and for writing it, without settling
  double settling = 0;  ///< s, of its piles; 0 if it has none, or if they were already settled
  double bytes = 0;     ///< of its series, before compression
  bool is_growing = false;  ///< pairs or contacts were still increasing: `seconds` is a lower bound
};

/// A mean over sampled runs, and the interval of twice its standard error.
struct MeanOfSample {
  double mean = 0, low = 0, high = 0;
};
/// `values`: one or more values, drawn without repetition from a population of `population` values.
/// If they are the whole population, the mean is exact. With one value of several, the interval is
/// 0 .. infinity.
MeanOfSample MeanOf(const std::vector<double>& values, std::uint64_t population);

struct SweepEstimate {
  std::uint64_t runs = 0, points = 0;
  std::string runs_text;  ///< the number of runs in words
  std::vector<SampledRun> samples;
  std::vector<std::string> failures;  ///< reasons why sampled runs failed
  std::uint64_t cycles = 0;           ///< most cycles of a sampled run
  bool has_references = false;        ///< runs are compared with reference runs, whose cost is not
                                      ///< included
  bool has_journal = true;            ///< a journal can be written here, and its time is included
  /// The number of different piles: of all runs, approximately, and of the sampled runs, which are
  /// settled.
  std::uint64_t piles = 0, settled_piles = 0;
};

/// Executes runs at about kSampledRuns points, spread over the grid, one after the other, for
/// kSampledCycles and then for as many more as take a few seconds. Writes a journal to a folder in
/// the current one, which it removes. Throws ScheduleError, and CommandError for runs
/// that count instructions.
SweepEstimate EstimateSweep(const grid::Grid& grid, const process::StopFlag& stop);
inline constexpr std::size_t kSampledRuns = 9;
inline constexpr std::uint64_t kSampledCycles = 30;

/// Time to settle a pile, s: the mean of those that sampled runs settled; nullopt if there were
/// none.
std::optional<double> SettlingTime(const SweepEstimate& estimate);

/// Runs, bytes and hours, with the measured figures and the unknowns.
std::string EstimateText(const SweepEstimate& estimate, const std::string& benchmark,
                         std::uint64_t jobs);

}  // namespace cdb::plans
