// Makes runs that are compared with one another omit the same components.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "compiler/plan/plan.h"

namespace cdb::schedule {

/// The visible components (schema::ComponentInfo) decided by `omit auto` that the runs of a plan
/// omitted or kept. Runs that differ only in detector, narrow phase, pair order, threads, seed or
/// repeat are compared: a component that one of them keeps, all must keep, or their times are of
/// different work. Not thread-safe.
class SharedOmissions {
 public:
  /// Records a run that succeeded. `omitted` and `decisions` as in results::RunResult.
  void Note(const plan::Run& run, std::string_view omitted, std::string_view decisions);

  /// Removes the record of a run. Components that it kept are still kept by others.
  void Forget(const plan::Run& run) { omitted_.erase(run.id); }

  /// The names of the components that the run has to keep because a run compared with it keeps
  /// them, separated by spaces; empty if its own decision stands.
  std::string KeptFor(const plan::Run& run) const;

  /// The names of the components that the run was recorded without and has to keep; empty if its
  /// times are valid.
  std::string MissingIn(const plan::Run& run) const;

 private:
  using Components = std::uint32_t;  ///< one bit each

  Components KeptInGroupOf(const plan::Run& run) const;

  std::unordered_map<std::string, Components> kept_;     ///< by group of runs
  std::unordered_map<std::string, Components> omitted_;  ///< by the run's id
};

}  // namespace cdb::schedule
