// The layout of a results file: its dimensions, arrays and attributes.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/protocol/series.h"
#include "runtime/results/hdf5/dataset.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/hdf5/object.h"
#include "runtime/results/store.h"

namespace cdb::results {

// The tables of the facts about each run in a results file, other than its series, and the facts
// that follow from all runs of a plan together.

/// The groups of the file. Names of arrays include their group: `run/host`.
inline constexpr std::string_view kRunGroup = "run/";
inline constexpr std::string_view kAccuracyGroup = "accuracy/";
inline constexpr std::string_view kSampledGroup = "sampled/";
inline const std::string kReferenceGroup = "accuracy/reference/";
inline const std::string kRequirementsGroup = "requirements/";
inline const std::string kBoundaryGroup = "boundary/";
inline const std::string kRaceGroup = "race/";

/// In place of `time`, in the documentation of a number from a clock that counts instructions.
inline constexpr std::string_view kInstructions = "number of instructions in the";
/// Whether a variable, by its name for readers, is in the unit of the clock of the runs.
bool IsByClock(std::string_view dataset);

/// A missing real number.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// An array over the grid that holds one number for each run.
struct RunNumber {
  std::string name;  ///< including its group
  hdf5::Type type;
  std::string unit;
  std::string doc;
  double missing;  ///< value of cells without a run
  std::function<double(const RunResult&)> get;
  /// Meanings of its values from 0 on, separated by spaces; null if it is a number.
  std::string (*flags)() = nullptr;
};
const std::vector<RunNumber>& RunNumbers();

/// The same for text; empty if there is no run.
struct RunText {
  std::string name;  ///< including its group
  std::string doc;
  std::string (*get)(const plan::Run&, const RunResult&);
};
const std::vector<RunText>& RunTexts();
/// True if `run/NAME` exists.
bool IsRunFact(std::string_view name);

/// Facts that follow from all runs of a plan together. Not copyable: layouts point into it.
struct PlanFacts {
  /// Throws StoreError if an axis has the name of another object in the file.
  explicit PlanFacts(const plan::Plan& plan);
  PlanFacts(const PlanFacts&) = delete;
  PlanFacts& operator=(const PlanFacts&) = delete;
  std::string sha256;
  std::vector<bool> integer_axes;               ///< Axis::IsInteger of each axis
  std::uint64_t cycles;                         ///< extent of `cycle`
  std::uint64_t bodies;                         ///< extent of `body`
  std::uint64_t box_bodies;                     ///< extent of `box_body`
  std::uint64_t queries;                        ///< extent of `query_row`
  std::uint64_t nodes;                          ///< extent of `vertex`
  std::vector<const protocol::Series*> series;  ///< recorded by some run
  bool poses, boxes, contacts, answers;         ///< some run records them
  bool counts_instructions;                     ///< the clock of all runs counts instructions
  std::vector<RunNumber> numbers;               ///< RunNumbers(), and those of /accuracy
  std::vector<RunText> texts;                   ///< RunTexts(), and those of /accuracy
  std::vector<protocol::Series> error_series;   ///< of /accuracy, over `sample`
  std::uint64_t samples = 0;                    ///< extent of `sample`; 0 if no run has samples
  std::uint64_t sampled_bodies = 1;             ///< extent of `body` of the references
  double interval_s = 0;                        ///< time between samples
};

/// An array over the references of a plan, in a merged file.
struct ReferenceArray {
  std::string name;  ///< without its group
  hdf5::Type type;
  std::vector<std::string> dimensions;  ///< `reference` first
  std::string unit;
  std::string doc;
  std::string (*flags)() = nullptr;  ///< as in RunNumber
};
const std::vector<ReferenceArray>& ReferenceArrays();

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

/// What varies along an axis of sampled points: known before the first run.
struct Column {
  std::string name, dimension;  ///< including their group
  std::vector<double> values;
  std::map<std::string, std::string> attributes;
  double first, last;  ///< of the range
};

struct Layout {
  /// First the axes, in the order of the plan, then `rep`. Each group has the dimensions of its
  /// arrays, with their coordinates, so that a reader of one group can select by label.
  std::vector<Dimension> dimensions;
  std::vector<Array> arrays;
  std::vector<Column> columns;
  hdf5::Shape grid;  ///< extents of the axes and of `rep`

  const Array& Get(std::string_view name) const;
};

/// `contact_rows`: extent of `contact`.
Layout MakeLayout(const plan::Plan& plan, const PlanFacts& facts, std::uint64_t contact_rows);

/// The indices of the cell at `index`, in grid order, of a grid with these extents.
hdf5::Shape CellAt(const hdf5::Shape& grid, std::size_t index);

/// The number of chunks of a chunked array for one cell of the grid (`outer` dimensions), and the
/// first element of the one numbered `index` of cell `cell`.
std::uint64_t ChunksOfCell(const Array& array, std::size_t outer);
hdf5::Shape ChunkStart(const Array& array, const hdf5::Shape& cell, std::uint64_t index);

// Writes a layout into a file, and the attributes that identify the file.

/// Creates every dataset, with scales and attributes. Coordinates are filled, arrays are not.
void CreateArrays(hdf5::File& file, const Layout& layout);

/// Fills the arrays of /requirements, if there are any; without `answers`, none was judged.
void WriteRequirements(hdf5::File& file, const std::vector<plan::Requirement>& requirements,
                       const StoredAnswers* answers);

/// Fills the arrays of /boundary, if there are any.
void WriteBoundaries(hdf5::File& file, const plan::Plan& plan, const StoredAnswers* answers);
/// Fills the arrays of /race, if there are any.
void WriteRaces(hdf5::File& file, const plan::Plan& plan, const StoredAnswers* answers);

/// Writes the attributes of the file itself. `what` is the line of `history`.
void WriteHead(hdf5::File& file, const plan::Plan& plan, const PlanFacts& facts,
               std::string_view what);

}  // namespace cdb::results
