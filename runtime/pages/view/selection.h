// Selects the run of a sweep to show: turns `axis=value` words into a cell.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "runtime/figures/points.h"
#include "runtime/protocol/series.h"
#include "runtime/results/store.h"

namespace cdb::view {

/// Changes the cell to the selected values, each `axis=value` or `rep=2`; other axes keep theirs.
/// Throws files::StoreError for an axis or a value that the sweep does not have.
void Select(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
            const std::vector<figures::AxisSelection>& selections, results::ResultFile::Cell& cell);

/// `detector dbvt, quantity 100, rep 0`; the repeat only if there are several. Empty for a sweep of
/// one run.
std::string CellName(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
                     const results::ResultFile::Cell& cell);

// The data for drawing a run: its bodies, and their poses in each frame.
//
// A frame shows the state after a recorded cycle. Without poses there is one frame, the start.
// Lengths in m, times in s.

/// The unit of durations of a run that counts instructions.
inline constexpr const char* kInstructions = "instructions";

/// A series of the run: one value for each cycle that ran, or, for an error, for each sample. NaN:
/// no value.
struct CycleSeries {
  std::string name, unit;
  std::vector<double> values;
  double interval_s = 0;  ///< time between samples, the first of which is at time 0; 0: one value
                          ///< per cycle
};

struct SceneRecording {
  std::string file;  ///< as the user named it
  std::string benchmark, title;
  std::string name;  ///< its coordinates in the sweep; empty for a sweep of one run
  plan::Scene scene;
  layouts::InitialState state;  ///< without positions if there are poses
  bool is_run = false;          ///< from a results file
  results::Status status = results::Status::kMissing;
  protocol::Judgement judgement;
  std::string unchecked;       ///< questions that the verdict leaves open
  std::string message;         ///< reason why it failed; may be empty
  std::uint64_t n_cycles = 0;  ///< number of cycles that ran

  /// Cycles of the frames; empty if the only frame is the start.
  std::vector<std::uint64_t> cycles;
  std::uint64_t every = 1;    ///< cycles from one frame to the next
  std::vector<double> poses;  ///< (frame, object, 7), as in the results
  std::vector<char> unmoved;  ///< (frame, object): the pose is identical to the bit to that of the
                              ///< previous cycle
  std::vector<double> boxes;  ///< (frame, object, 6); empty if not recorded
  std::vector<double> nodes;  ///< (frame, node, 3) of the soft bodies, in the order of the objects
  bool has_contacts = false;  ///< contacts were recorded
  std::vector<std::vector<protocol::ContactRecord>> contacts;  ///< for each frame
  std::vector<CycleSeries> durations;                          ///< of the phases, ns
  std::vector<CycleSeries> series;   ///< all other recorded series, and errors
  std::vector<std::string> notices;  ///< notices for the viewer: missing data, with the reason

  std::size_t FrameCount() const { return cycles.empty() ? 1 : cycles.size(); }
  std::size_t ObjectCount() const { return state.objects.size(); }
};

/// The cycles to show.
struct FrameChoice {
  std::uint64_t first = 0;
  std::optional<std::uint64_t> last;      ///< default: the last that ran
  std::optional<std::uint64_t> every;     ///< default: 1, or more if the page would be too large
  std::size_t budget_bytes = 14'000'000;  ///< for all frames, before they become text
};
/// `A..B`, `A..`, `..B` or `A`. Throws files::StoreError.
void ParseCycles(const std::string& text, FrameChoice& choice);

/// The first cell in grid order that has poses, else the first that ran, else the first. Throws
/// StoreError.
results::ResultFile::Cell DefaultCell(const results::ResultFile& file);

/// Throws StoreError for a cell without a run, a run on a trace, results of another version of the
/// plan, or cycles that did not run; library::SceneError if the objects cannot be drawn again.
SceneRecording ReadRecording(const results::ResultFile& file, const results::ResultFile::Cell& cell,
                             const FrameChoice& choice);

/// The start of a run that has not been executed. Objects of a pile are at the poses from which
/// they are dropped. Throws StoreError for a run on a trace; library::SceneError if the objects
/// cannot be placed.
SceneRecording StartOf(const plan::Plan& plan, const plan::Run& run);

/// Bytes of a frame in a page: for each pose, box and contact (on average).
inline constexpr std::size_t kPoseBytes = 18, kBoxBytes = 24, kContactBytes = 36,
                             kCoordinateBytes = 4;

}  // namespace cdb::view
