// All journals of a sweep: one on a local disk, and on a network file system one of each process
// that has worked on it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/results/journal/journal.h"

namespace cdb::journal {

/// The journals in a folder, sorted by name; none if it cannot be read.
std::vector<std::filesystem::path> JournalsIn(const std::filesystem::path& folder);

/// The finished runs of several journals as they are when this is made. Runs that are written later
/// are not found; of one that is rewritten, the new one is. Not thread-safe.
class Journals {
 public:
  /// `places`: folders of journals, and single journals; those that do not exist have no runs.
  /// Of a run that several of them hold, the one in the first place counts, and of those in one
  /// folder the newest. Throws StoreError, DamagedJournal.
  explicit Journals(const std::vector<std::filesystem::path>& places);

  bool Has(const std::string& run_id) const { return rows_.contains(run_id); }
  /// The journal in which Find looks first; the run must be there.
  const std::filesystem::path& PathOf(const std::string& run_id) const {
    return journals_[rows_.at(run_id).journal].path();
  }
  std::size_t size() const { return rows_.size(); }
  /// Nullopt if no journal has the run. Throws DamagedRun if none has it as it was written.
  std::optional<Record> Find(const std::string& run_id);
  /// Throws StoreError if one is of another plan.
  void RequirePlan(const plan::Plan& plan, const std::string& plan_sha256) const;
  /// Throws DamagedRun for a run that is not in the plan.
  void RequireRuns(const std::function<bool(const std::string& run_id)>& is_in_plan) const;

 private:
  struct Place {
    std::uint32_t journal;
    std::uint32_t rank;  ///< of its argument
    std::int64_t row, written_ns;
    bool operator<(const Place& other) const {
      return rank != other.rank ? rank < other.rank : written_ns > other.written_ns;
    }
  };
  void Add(const std::filesystem::path& file, std::uint32_t rank);

  std::vector<Journal> journals_;
  std::unordered_map<std::string, Place> rows_;
  std::unordered_multimap<std::string, Place> others_;  ///< of the same runs
};

// What was asked of the sweep in `folder`. Journals that cannot be read are passed over.

/// The newest value of each request in all journals.
std::map<std::string, std::string> FindRequests(const std::filesystem::path& folder);
/// Empty if there is none.
std::string FindRequest(const std::filesystem::path& folder, const std::string& what);
/// Writes a request into the journal of this process. Throws StoreError.
void Ask(const std::filesystem::path& folder, const std::string& plan_sha256,
         const std::string& what, const std::string& value);

inline constexpr const char* kFresh = "fresh";  ///< newer than the result; value: the plan
inline constexpr const char* kRetry = "retry";  ///< runs to be run again
inline constexpr const char* kSubmission = "submission";  ///< cluster/submission.h

/// The number of finished runs in all journals of the folder, each counted as often as it is there.
/// Throws StoreError.
std::uint64_t CountRuns(const std::filesystem::path& folder);
/// True if every run of the plan, and every reference, is in a journal; `places` as for Journals.
bool HasAllRuns(const plan::Plan& plan, const std::vector<std::filesystem::path>& places);

/// Removes all journals in the folder, first those with a request, without which the others are
/// leftovers. No process may have one open. Throws StoreError.
void RemoveJournals(const std::filesystem::path& folder);

}  // namespace cdb::journal
