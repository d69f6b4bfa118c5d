// The findings of the pair referee, for summaries: detectors that missed pairs, and where (`record
// pairs`).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/statistics/cells.h"
#include "runtime/store/store.h"

namespace cdb::statistics {

/// The findings for one detector or narrow phase over all runs of a file; a run that fills several
/// cells counts once.
struct DetectorFindings {
  std::string detector;
  std::size_t runs = 0;  ///< with recorded pairs
  std::uint64_t cycles = 0;
  std::uint64_t exact = 0, missed = 0, false_positives = 0, duplicate = 0;
  /// Overlaps that were compared, those without a contact, and those that could not be compared.
  std::uint64_t exact_contacts = 0, missed_contacts = 0, unsure_contacts = 0;
  /// Means over the cycles that have a value; NaN if none has.
  double depth_error = 0, normal_error = 0;
  std::size_t wrong_runs = 0;  ///< with a missed pair
  struct Place {
    store::ResultFile::Cell cell;
    std::uint64_t cycle;
  };
  std::optional<Place> first_missed, first_duplicate, first_missed_contact;
  std::size_t failed_runs = 0;  ///< that failed, whatever they recorded
  std::optional<store::ResultFile::Cell> first_failed;
  std::size_t unwatched_runs = 0;  ///< without recorded pairs
  std::size_t AllRuns() const { return runs + unwatched_runs; }
};

/// In the order of the axis of detectors, or else of the cells. Throws StoreError.
std::vector<DetectorFindings> FindingsOf(const store::ResultFile& file);
/// For each name, such as that of a narrow phase, the findings of the cells that have it; in the
/// order of the cells.
std::vector<DetectorFindings> FindingsBy(
    const store::ResultFile& file,
    const std::function<std::string(const store::ResultFile::Cell&)>& name_of);

/// Lines for the head of a summary, before any timing: detectors that missed pairs, and those that
/// are known to miss some and were not checked. Empty if there are none.
std::string WrongDetectors(const store::ResultFile& file,
                           const std::vector<DetectorFindings>& findings);

/// Lines for below the figures: other faults of detectors.
std::string OtherFaults(const std::vector<DetectorFindings>& findings);

}  // namespace cdb::statistics
