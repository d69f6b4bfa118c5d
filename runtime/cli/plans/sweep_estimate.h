// What a sweep will cost, from a few of its runs that are run for a few cycles.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/grid/grid.h"
#include "runtime/process/stop.h"

namespace cdb::plans {

/// A run that was executed for a few cycles.
struct SampledRun {
  double seconds = 0;   ///< predicted for all of its cycles and for its shard, without settling
  double settling = 0;  ///< s, of its piles; 0 where it has none, or found them settled
  double bytes = 0;     ///< of its series, before compression
};

/// A mean over sampled runs, and the interval of twice its standard error.
struct MeanOfSample {
  double mean = 0, low = 0, high = 0;
};
/// Of `values`, one or more, drawn from `population` of them without repetition: where these are
/// all, the mean is exact. Of one value of several, the interval is 0 .. infinity.
MeanOfSample MeanOf(const std::vector<double>& values, std::uint64_t population);

struct SweepEstimate {
  std::uint64_t runs = 0, points = 0;
  std::vector<SampledRun> samples;
  std::vector<std::string> failures;  ///< why sampled runs did not end well
  std::uint64_t cycles = 0;           ///< that each was run for, at most
  bool has_references = false;        ///< runs are compared with reference runs, which come on top
  bool has_shards = true;             ///< shards could be written here, and their time is included
  /// Different piles of all runs, about, and of the sampled runs, which are settled by now.
  std::uint64_t piles = 0, settled_piles = 0;
};

/// Runs about kSampledRuns points, spread over the grid, one after the other. Writes their shards
/// to a folder in the current one, which it removes. Throws ScheduleError.
SweepEstimate EstimateSweep(const grid::Grid& grid, const process::StopFlag& stop);
inline constexpr std::size_t kSampledRuns = 9;
inline constexpr std::uint64_t kSampledCycles = 30;

/// s, of a pile: the mean of those that sampled runs settled; nullopt where none did.
std::optional<double> SettlingTime(const SweepEstimate& estimate);

/// Runs, bytes and hours; what was measured, and what is not known.
std::string EstimateText(const SweepEstimate& estimate, const std::string& benchmark,
                         std::uint64_t jobs);

}  // namespace cdb::plans
