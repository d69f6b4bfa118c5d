// The layout of a results file: its dimensions, arrays and attributes. Shards and merged files are
// created from it alike.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/measure/series.h"
#include "runtime/store/dimensions.h"
#include "runtime/store/hdf5/dataset.h"
#include "runtime/store/store.h"

namespace cdb::store {

/// An array over the grid that holds one number for each run.
struct RunNumber {
  std::string name;
  hdf5::Type type;
  std::string unit;
  std::string doc;
  double missing;  ///< where there is no run
  std::function<double(const RunResult&)> get;
  /// What its values from 0 on mean, separated by spaces; empty where it is a number.
  std::string (*flags)() = nullptr;
};
const std::vector<RunNumber>& RunNumbers();

/// The same for text; empty where there is no run.
struct RunText {
  std::string name;
  std::string doc;
  std::string (*get)(const plan::Run&, const RunResult&);
};
const std::vector<RunText>& RunTexts();

/// What follows from all runs of a plan together. Not copied: layouts point into it.
struct PlanFacts {
  explicit PlanFacts(const plan::Plan& plan);
  PlanFacts(const PlanFacts&) = delete;
  PlanFacts& operator=(const PlanFacts&) = delete;
  std::string sha256;
  std::uint64_t cycles;                        ///< extent of `cycle`
  std::uint64_t bodies;                        ///< extent of `body`
  std::uint64_t box_bodies;                    ///< extent of `box_body`
  std::vector<const measure::Series*> series;  ///< that some run records
  bool poses, boxes, contacts;                 ///< some run records them
  std::vector<RunNumber> numbers;              ///< RunNumbers(), and those of /accuracy
  std::vector<RunText> texts;                  ///< RunTexts(), and those of /accuracy
  std::vector<measure::Series> error_series;   ///< of /accuracy, over `sample`
  std::uint64_t samples = 0;                   ///< extent of `sample`; 0 where no run has any
  double interval_s = 0;                       ///< from one to the next
};

/// Where /accuracy's arrays are, and those of its references.
inline constexpr const char* kAccuracyGroup = "accuracy/";
inline const std::string kReferenceGroup = "accuracy/reference/";

/// An array over the references of a plan, in a merged file.
struct ReferenceArray {
  std::string name;
  hdf5::Type type;
  std::vector<std::string> dimensions;  ///< `reference` first
  std::string unit;
  std::string doc;
  std::string (*flags)() = nullptr;  ///< as of RunNumber
};
const std::vector<ReferenceArray>& ReferenceArrays();

struct Array {
  std::string name;
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
  std::vector<Dimension> dimensions;  ///< the axes first, in the order of the plan, then `rep`
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
