// The layout of a results file: its dimensions, arrays and attributes.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/protocol/series.h"
#include "runtime/results/dimensions.h"
#include "runtime/results/hdf5/dataset.h"
#include "runtime/results/run_facts.h"

namespace cdb::results {

struct Array {
  std::string name;  ///< including its group
  hdf5::Type type = hdf5::Type::kFloat64;
  std::vector<std::string> dimensions;
  hdf5::Shape shape;
  hdf5::Shape chunk;  ///< empty: contiguous
  double fill = 0;
  bool has_fill_value = false;  ///< `fill` is declared to readers
  std::map<std::string, std::string> attributes;
  std::string flags;  ///< meanings of its values from 0 on, separated by spaces
  const protocol::Series* series = nullptr;
};

struct Layout {
  /// First the axes, in the order of the plan, then `rep`. Each group has the dimensions of its
  /// arrays, with their coordinates, so that a reader of one group can select by label.
  std::vector<Dimension> dimensions;
  std::vector<Array> arrays;
  hdf5::Shape grid;  ///< extents of the axes and of `rep`

  const Array& Get(std::string_view name) const;
};

/// `contact_rows`: extent of `contact`.
Layout MakeLayout(const plan::Plan& plan, const PlanFacts& facts, std::uint64_t contact_rows);

/// The number of chunks of a chunked array for one cell of the grid (`outer` dimensions), and the
/// first element of the one numbered `index` of cell `cell`.
std::uint64_t ChunksOfCell(const Array& array, std::size_t outer);
hdf5::Shape ChunkStart(const Array& array, const hdf5::Shape& cell, std::uint64_t index);

}  // namespace cdb::results
