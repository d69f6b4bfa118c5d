// Evaluates the errors of the runs of a plan, with references from the journal or closed forms.
#pragma once

#include <functional>
#include <list>
#include <map>
#include <optional>
#include <string>

#include "compiler/plan/plan.h"
#include "runtime/protocol/recording.h"
#include "runtime/results/journal/run_writer.h"

namespace cdb::schedule {

/// Plan must outlive it. Not thread-safe.
class ErrorEvaluator {
 public:
  /// `read`: the record of a finished reference run, by its id; throws StoreError.
  using ReadRecord = std::function<journal::Record(const std::string& run_id)>;
  ErrorEvaluator(const plan::Plan& plan, ReadRecord read);

  /// The errors of a run that has ended with `status`, from the samples in its recording. An error
  /// that cannot be computed has no value, and the message gives the reason; no exception is thrown
  /// for it.
  protocol::RunErrors ErrorsOf(const plan::Run& run, results::Status status,
                               const protocol::Recording& recording);

 private:
  /// A reference, read once and kept while it is among the most recently requested.
  /// Throws StoreError, hdf5::Error.
  const journal::Reference& Find(const std::string& id);
  protocol::RunErrors AgainstReference(const plan::Run& run, const protocol::Samples& samples);

  const plan::Plan& plan_;
  const ReadRecord read_;
  std::map<std::string, const plan::Run*, std::less<>> references_;
  std::list<std::pair<std::string, journal::Reference>> kept_;  ///< the most recently requested
                                                                ///< first
};

}  // namespace cdb::schedule
