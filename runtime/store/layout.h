// The layout of a results file: its dimensions, arrays and attributes. Shards and merged files are
// created from it alike.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/measure/series.h"
#include "runtime/store/dimensions.h"
#include "runtime/store/hdf5/dataset.h"
#include "runtime/store/run_facts.h"

namespace cdb::store {

struct Array {
  std::string name;  ///< with its group
  hdf5::Type type = hdf5::Type::kFloat64;
  std::vector<std::string> dimensions;
  hdf5::Shape shape;
  hdf5::Shape chunk;  ///< empty: contiguous
  double fill = 0;
  bool has_fill_value = false;  ///< readers are told of `fill`
  std::map<std::string, std::string> attributes;
  std::string flags;  ///< what its values from 0 on mean, separated by spaces
  const measure::Series* series = nullptr;
};

struct Layout {
  /// The axes first, in the order of the plan, then `rep`. Each group has the dimensions of its
  /// arrays, with their coordinates, so that a reader of one group can select by label.
  std::vector<Dimension> dimensions;
  std::vector<Array> arrays;
  hdf5::Shape grid;  ///< extents of the axes and of `rep`

  const Array& Get(std::string_view name) const;
};

/// Of the merged file, or of the shard of `run` (every axis and `rep` of length 1) where that is
/// not null. `contact_rows`: extent of `contact`.
Layout MakeLayout(const plan::Plan& plan, const PlanFacts& facts, const plan::Run* run,
                  std::uint64_t contact_rows);

/// Chunks that a chunked array has for one cell of the grid (`outer` dimensions), and the first
/// element of the one numbered `index` of cell `cell`.
std::uint64_t ChunksOfCell(const Array& array, std::size_t outer);
hdf5::Shape ChunkStart(const Array& array, const hdf5::Shape& cell, std::uint64_t index);

}  // namespace cdb::store
