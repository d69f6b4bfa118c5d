// The index of a shard: what a merge needs of it beside the bytes of its chunks, so that nothing of
// the shard has to be opened as HDF5. It stands behind the HDF5 file and before the seal, where
// HDF5 and its readers do not look.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/store/layout.h"
#include "runtime/store/run_facts.h"
#include "runtime/store/shards/shards.h"
#include "runtime/store/store.h"

namespace cdb::shards {

/// A chunk of a series as it stands in the shard, filtered.
struct IndexedChunk {
  std::uint32_t series = 0;  ///< its number among the arrays of the layout that are series
  std::uint32_t chunk = 0;   ///< its number within the cell
  std::uint32_t filter_mask = 0;
  std::uint64_t begin = 0, bytes = 0;
  bool operator==(const IndexedChunk&) const = default;
};

struct ShardIndex {
  /// LayoutChecksum of the layout that the numbers below refer to.
  std::uint64_t layout = 0;
  ShardInfo info;
  std::vector<double> numbers;       ///< as PlanFacts::numbers
  std::vector<std::string> texts;    ///< as PlanFacts::texts
  store::Provenance provenance;      ///< text attributes of /provenance
  std::vector<IndexedChunk> chunks;  ///< those that the shard holds
};

/// Of the schema version and of name, type, shape within a cell and chunks of every array that is
/// indexed: the same for all shards of a plan and for the merged file.
std::uint64_t LayoutChecksum(const store::Layout& layout, const store::PlanFacts& facts);

/// What stands behind the HDF5 file.
std::vector<std::byte> IndexBytes(const ShardIndex& index);

/// `shard`: all before the seal. Nullopt where it has no index that this version reads, or one
/// that does not fit the shard.
std::optional<ShardIndex> FindIndex(std::span<const std::byte> shard);

}  // namespace cdb::shards
