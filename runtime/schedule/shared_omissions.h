// Makes runs that are compared with one another leave out the same parts of the engine.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "compiler/plan/plan.h"

namespace cdb::schedule {

/// What the runs of a plan left out and kept of the visible components (schema::ComponentInfo) that
/// `omit auto` decides on. Runs that differ only in detector, narrow phase, pair order, threads,
/// seed or repeat are compared: what one of them keeps, all must keep, or their times are of
/// different work. Not for several threads.
class SharedOmissions {
 public:
  /// Notes a run that ended well. `omitted` and `decisions` as in store::RunResult.
  void Note(const plan::Run& run, std::string_view omitted, std::string_view decisions);

  /// As if the run had never been noted; what it kept, others keep all the same.
  void Forget(const plan::Run& run) { omitted_.erase(run.id); }

  /// The names of the components that the run has to keep, as a run that it is compared with keeps
  /// them, separated by spaces; empty where its own decision stands.
  std::string KeptFor(const plan::Run& run) const;

  /// The names of those that the run was noted without and has to keep; empty where its times
  /// stand.
  std::string MissingIn(const plan::Run& run) const;

 private:
  using Components = std::uint32_t;  ///< a bit each

  Components KeptInGroupOf(const plan::Run& run) const;

  std::unordered_map<std::string, Components> kept_;     ///< by group of runs
  std::unordered_map<std::string, Components> omitted_;  ///< by the run's id
};

}  // namespace cdb::schedule
