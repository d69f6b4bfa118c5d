// Shards of reference runs. They are not points of the grid, and contain only samples. As
// crash-safe as any shard.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "runtime/store/hdf5/file.h"
#include "runtime/store/layout.h"
#include "runtime/store/store.h"

namespace cdb::shards {

/// A reference run as its shard holds it.
struct ReferenceShard {
  store::Status status = store::Status::kMissing;
  std::string message;         ///< why it did not end well
  measure::SampleShape shape;  ///< of `values`
  std::vector<double> values;  ///< of Samples; empty where it did not end well
};

/// Writes `folder/<run id>.h5` of a run of a plan's references as ShardWriter does, with the
/// samples that it took. Throws StoreError.
void WriteReference(const std::string& plan_sha256, const plan::Run& run,
                    const store::RunResult& result, std::span<const double> samples,
                    const store::Provenance& provenance, const std::filesystem::path& folder);

/// Throws StoreError for what is no whole shard of that run of that plan.
ReferenceShard ReadReference(const std::string& plan_sha256, const plan::Run& run,
                             const std::filesystem::path& file);

/// Fills the arrays of /accuracy/reference from the shard of each of `plan.references`; those
/// without a path are as in `base`, a merged file, or `missing` where that is null. Throws
/// StoreError, h5::Error.
void MergeReferences(const plan::Plan& plan, const store::Layout& layout,
                     const std::vector<std::filesystem::path>& paths, const hdf5::File* base,
                     hdf5::File& file);
/// Holds what MergeReferences wrote against the shards. Throws h5::Error.
void VerifyReferences(const plan::Plan& plan, const store::Layout& layout,
                      const std::vector<std::filesystem::path>& paths, const hdf5::File* base,
                      const hdf5::File& file);

}  // namespace cdb::shards
