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

/// The contents of the shard of a reference run.
struct ReferenceShard {
  store::Status status = store::Status::kMissing;
  std::string message;         ///< reason why it failed
  measure::SampleShape shape;  ///< layout of `values`
  std::vector<double> values;  ///< as in Samples; empty if it failed
};

/// Writes `folder/<run id>.h5` for a reference run of a plan, as ShardWriter does, with its
/// samples. Throws StoreError.
void WriteReference(const std::string& plan_sha256, const plan::Run& run,
                    const store::RunResult& result, std::span<const double> samples,
                    const store::Provenance& provenance, const std::filesystem::path& folder);

/// Throws StoreError unless the file is an intact shard of that run of that plan.
ReferenceShard ReadReference(const std::string& plan_sha256, const plan::Run& run,
                             const std::filesystem::path& file);

/// Fills the arrays of /accuracy/reference from the shard of each of `plan.references`. Those
/// without a path are taken from `base`, a merged file, or are `missing` if that is null. Throws
/// StoreError, hdf5::Error.
void MergeReferences(const plan::Plan& plan, const store::Layout& layout,
                     const std::vector<std::filesystem::path>& paths, const hdf5::File* base,
                     hdf5::File& file);
/// Compares the arrays written by MergeReferences with the shards. Throws hdf5::Error.
void VerifyReferences(const plan::Plan& plan, const store::Layout& layout,
                      const std::vector<std::filesystem::path>& paths, const hdf5::File* base,
                      const hdf5::File& file);

}  // namespace cdb::shards
