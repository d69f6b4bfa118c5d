// Evaluates the errors of the runs of a plan, with references from the shards or closed forms.
#pragma once

#include <filesystem>
#include <list>
#include <map>
#include <optional>
#include <string>

#include "compiler/plan/plan.h"
#include "runtime/measure/recording.h"
#include "runtime/store/shards/reference_shard.h"

namespace cdb::schedule {

/// Plan and folder of shards must outlive it. Not thread-safe.
class ErrorEvaluator {
 public:
  ErrorEvaluator(const plan::Plan& plan, std::filesystem::path folder);

  /// The errors of a run that has ended with `status`, from the samples in its recording. An error
  /// that cannot be computed has no value, and the message gives the reason; no exception is thrown
  /// for it.
  measure::RunErrors ErrorsOf(const plan::Run& run, store::Status status,
                              const measure::Recording& recording);

 private:
  /// The shard of a reference, read once and kept while it is among the most recently requested.
  /// Throws StoreError.
  const shards::ReferenceShard& Find(const std::string& id);
  measure::RunErrors AgainstReference(const plan::Run& run, const measure::Samples& samples);

  const plan::Plan& plan_;
  const std::string plan_sha256_;
  const std::filesystem::path folder_;
  std::map<std::string, const plan::Run*, std::less<>> references_;
  std::list<std::pair<std::string, shards::ReferenceShard>> kept_;  ///< the most recently requested
                                                                    ///< first
};

}  // namespace cdb::schedule
