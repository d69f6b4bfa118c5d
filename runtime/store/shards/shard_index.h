// The index of a shard: the data that a merge needs in addition to the bytes of its chunks, so that
// the shard need not be opened as HDF5. It is stored after the HDF5 file and before the seal, where
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

/// A chunk of a series as stored in the shard, filtered.
struct IndexedChunk {
  std::uint32_t series = 0;  ///< index among those arrays of the layout that are series
  std::uint32_t chunk = 0;   ///< index within the cell
  std::uint32_t filter_mask = 0;
  std::uint64_t begin = 0, bytes = 0;
  bool operator==(const IndexedChunk&) const = default;
};

struct ShardIndex {
  /// LayoutChecksum of the layout to which the indices below refer.
  std::uint64_t layout = 0;
  ShardInfo info;
  std::vector<double> numbers;       ///< in the order of PlanFacts::numbers
  std::vector<std::string> texts;    ///< in the order of PlanFacts::texts
  store::Provenance provenance;      ///< text attributes of /provenance
  std::vector<IndexedChunk> chunks;  ///< those that the shard contains
};

/// Covers the schema version, and name, type, shape within a cell and chunks of every indexed
/// array: equal for all shards of a plan and for the merged file.
std::uint64_t LayoutChecksum(const store::Layout& layout, const store::PlanFacts& facts);

/// The bytes to append to the HDF5 file.
std::vector<std::byte> IndexBytes(const ShardIndex& index);

/// `shard`: all bytes before the seal. Nullopt if it has no index that this version reads, or one
/// that does not match the shard.
std::optional<ShardIndex> FindIndex(std::span<const std::byte> shard);

}  // namespace cdb::shards
