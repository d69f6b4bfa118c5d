// The figures of detectors: what the pair referee found (`record pairs`), the cost of each, its
// growth, and the overhead of calling it.
//
// Times in ns, memory in bytes; NaN where the file has no value. Throws StoreError.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/figures/bootstrap.h"
#include "runtime/figures/points.h"
#include "runtime/results/store.h"

namespace cdb::figures {

class Model;

struct Place {
  Cell cell;
  std::uint64_t cycle;
};

/// The findings for one detector over all runs of a file; a run that fills several cells counts
/// once.
struct DetectorFindings {
  std::string detector;
  std::size_t runs = 0;  ///< with recorded pairs
  std::uint64_t cycles = 0;
  std::uint64_t exact = 0, missed = 0, false_positives = 0, duplicate = 0;
  std::uint64_t missed_contacts = 0;  ///< by any phase
  /// Of exact pairs of a deforming mesh; none on other traces and in live worlds.
  std::optional<std::uint64_t> collisions = {}, missed_collisions = {};
  std::size_t wrong_runs = 0;  ///< with a missed pair
  std::optional<Place> first_missed, first_duplicate;
  std::size_t failed_runs = 0;  ///< that failed, whatever they recorded
  std::optional<Cell> first_failed;
  std::size_t unwatched_runs = 0;  ///< without recorded pairs
  std::size_t AllRuns() const { return runs + unwatched_runs; }
};

/// In the order of the axis of detectors, or else of the cells. Throws StoreError.
std::vector<DetectorFindings> FindingsOf(const results::ResultFile& file);

/// The findings for one narrow phase, over the pairs that were given to it in all runs of a file.
struct ContactFindings {
  std::string narrow_phase;  ///< a detector, or kBulletPhase; empty if there was no contact
  std::size_t runs = 0;      ///< with recorded contacts
  std::uint64_t cycles = 0;
  std::uint64_t exact = 0, missed = 0;  ///< of the overlaps that were compared
  std::uint64_t uncompared = 0;
  /// Means over the cycles that have a value, of all contacts of the runs; NaN if none has.
  double depth_error = 0, normal_error = 0;
  std::optional<Place> first_missed;
  std::uint64_t All() const { return exact + uncompared; }
};
inline constexpr const char* kBulletPhase = "bullet";

/// In the order of the cells, without narrow phases that had nothing to do, unless all had. Empty
/// if the file is from before overlaps were counted. Throws StoreError.
std::vector<ContactFindings> ContactFindingsOf(const results::ResultFile& file);

/// Over all points of a row.
struct DetectorCosts {
  Estimate mean;         ///< of a cycle
  double worst = kNone;  ///< cycle
  double pairs = kNone;  ///< mean
  double missed = kNone,
         phantom = kNone;                 ///< sums; NaN if pairs were not checked in any cycle
  double peak_rss = kNone, heap = kNone;  ///< maxima
};
DetectorCosts CostsOf(const Model& model, const Row& row, protocol::Phase phase);

/// A sentence on whether the motion of each scene is the same with every detector, to the last bit.
/// Empty without detectors to compare, or where nothing was judged to move.
std::string SameMotionText(const results::ResultFile& file);
/// One of the four of Bullet, which do not use the interface of detectors.
bool IsOfBullet(const std::string& detector);
/// True if some run has `pair_order sorted`.
bool SortsPairs(const results::ResultFile& file);
/// A sentence on the phases in which the compared detectors sort their pairs, if these differ.
std::string SortingText(const results::ResultFile& file);

/// p of time ~ objects^p, by least squares over the logarithms of means.
struct DetectorGrowth {
  std::size_t axis;               ///< the axis that changes the number of objects
  std::vector<std::size_t> rows;  ///< the axes of the rows, without that one
  struct Exponent {
    PowerFit fit;                        ///< of all curves that the row pools
    std::vector<PowerGroup> curves;      ///< numbers of objects and times
    double least = kNone, most = kNone;  ///< range of the numbers of objects in the fit
  };
  std::map<Point, Exponent> exponents;   ///< by row
  bool is_mean = false;                  ///< some row pools several curves
  bool is_matched = true;                ///< all rows are fitted over the same numbers of objects
  std::size_t dropped = 0;               ///< numbers of objects that some row lacks
  std::vector<std::string> unlike = {};  ///< components that some points omitted and others kept
};
/// Fitted over the sound points at each value of the axes other than the one that changes the
/// number of objects, and over the numbers of objects that all rows have, if there are at least
/// three. Nullopt if no axis with at least three numbers changes it, or several do.
std::optional<DetectorGrowth> GrowthByRow(const Model& model, const std::vector<std::size_t>& rows,
                                          protocol::Phase phase = protocol::Phase::kDetect);

/// The overhead of calling a detector in a cycle, in relation to the fastest detector.
struct HarnessCost {
  struct Fastest {
    double time;           ///< the median over its points
    std::string detector;  ///< empty if the plan cannot be read
    bool is_only;
  };
  double median;
  std::optional<Fastest> fastest;  ///< nullopt if no detector has timings
};
/// Nullopt if no run states it.
std::optional<HarnessCost> HarnessCostOf(const Model& model);

}  // namespace cdb::figures
