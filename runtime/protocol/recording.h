// The shared memory into which a worker writes its measurements: an anonymous file that the worker
// and the runner both map. Values written before a crash or a timeout are preserved, and recording
// a value is a store, not a system call.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "compiler/plan/plan.h"
#include "compiler/schema/series.h"
#include "dsl/text/check.h"
#include "runtime/protocol/samples.h"
#include "runtime/protocol/series.h"

namespace cdb::protocol {

/// The exact depth is computed for at most this many possible overlaps of a cycle, in about half a
/// second; if there are more, for a random sample of this size (`record pairs`, metric geometry).
inline constexpr std::size_t kMostComparedContacts = 5000;

// Text of bounded size in memory that another process may have damaged.

/// Truncates text that does not fit.
template <std::size_t kSize>
class FixedText {
 public:
  static constexpr std::size_t kMaxLength = kSize - 1;

  FixedText& operator=(std::string_view text) {
    const std::size_t length = std::min(text.size(), kMaxLength);
    std::memcpy(text_, text.data(), length);
    text_[length] = '\0';
    return *this;
  }
  /// Ends at the end of the memory if the terminator was overwritten.
  std::string str() const { return std::string(text_, strnlen(text_, kSize)); }

 private:
  char text_[kSize] = {};
};

// Progress of a worker in settling the piles of its scene, before the first cycle.

enum class SettlingPhase : std::uint32_t {
  kNone,     ///< no pile, not started, or all at rest
  kWaiting,  ///< another run settles the same pile
  kSettling,
};

/// In the header of a recording: written by the worker, read by the runner meanwhile.
struct Settling {
  std::atomic<SettlingPhase> phase;
  std::atomic<std::uint32_t> at_rest, objects;  ///< over all piles
  std::atomic<double> seconds;  ///< time that this run has spent on settling; 0 if it found settled
                                ///< piles
};

/// `340 of 1000 objects are at rest`, `another run settles the same pile`; empty if no pile is
/// settling.
std::string SettlingText(const Settling& settling);

/// The outcome of a worker.
enum class WorkerOutcome : std::int32_t {
  kRunning = 0,
  kDone = 1,
  kFailed = 2,
  kAgain = 3,  ///< the runner must start the run again with kStartAgainKeeps kept; `message`: the
               ///< reason
};
/// Names of components, in the format of kKeepOption.
inline constexpr const char* kStartAgainKeeps = "walls";

/// Reference values for verdicts, for a run that records stability; NaN otherwise.
struct VerdictScales {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double initial_energy = kNone;  ///< J, as the series `energy`, before the first recorded cycle
  /// J: the kinetic energy at that time plus that of each object falling by 25 times its least
  /// side.
  double energy_scale = kNone;
  double least_side = kNone;   ///< m, of the smallest object
  double speed_scale = kNone;  ///< m/s, sqrt(g size) of that object
  double moving_objects = 0;   ///< number of objects that are not fixed
};

/// The start of the message of a run that failed because it ran out of memory.
inline constexpr std::string_view kOutOfMemory = "out of memory";

/// The header of the memory. Written by the worker, read by the runner after the worker has exited.
struct RecordingHeader {
  static constexpr std::uint64_t kMagic = 0x39'47'4e'49'44'52'43'00;  // "\0CRDING9"
  std::uint64_t magic;
  std::uint64_t bytes;  ///< size of the whole memory
  std::atomic<std::uint64_t> cycles_done;
  std::atomic<WorkerOutcome> outcome;
  std::atomic<std::uint32_t> plugin_call;       ///< the current call into a plug-in
  std::atomic<std::uint32_t> is_out_of_memory;  ///< nonzero once an allocation has failed
  Settling settling;
  FixedText<20> state_hash;   ///< 16 hex digits after the last cycle; empty before
  FixedText<2048> message;    ///< reason why the run failed, for the user, or why it must start
                              ///< again; of a finished run, the first pair that its detector missed
  FixedText<256> omitted;     ///< names of the omitted components (compiler/analysis/pruning.h)
  FixedText<4096> decisions;  ///< the decision about each component, and its reason
  FixedText<4096> models;     ///< the hulls of the compounds in the scene (ModelsText)
  schema::RunScalars scalars;
  VerdictScales scales;
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// A mapping of one run's recording, between inaccessible pages. Not copyable; unmapped and closed
/// on destruction. Not thread-safe.
class Recording {
 public:
  /// Runner: creates the memory for `scene`, filled with "no value" (-1 and NaN). Throws
  /// std::system_error.
  static Recording Create(const plan::Scene& scene);
  /// Worker: maps the runner's memory and touches every page, so that no cycle includes a page
  /// fault. Closes `fd`. Throws std::runtime_error if the memory is not a recording of this scene.
  static Recording Open(int fd, const plan::Scene& scene);

  Recording(Recording&& other) noexcept;
  Recording& operator=(Recording&&) = delete;
  ~Recording();

  /// Restores the state after Create, for a run that starts again.
  void Clear();

  int fd() const { return fd_; }
  RecordingHeader& header() { return *header_; }
  const RecordingHeader& header() const { return *header_; }

  /// The values of a series, in the layout of `Series::shape`; empty if the scene does not record
  /// it.
  std::span<std::int32_t> Ints(schema::IntSeries series) { return Values<std::int32_t>(*series); }
  std::span<double> Reals(schema::RealSeries series) { return Values<double>(*series); }
  std::span<const std::int32_t> Ints(schema::IntSeries series) const {
    return Values<std::int32_t>(*series);
  }
  std::span<const double> Reals(schema::RealSeries series) const { return Values<double>(*series); }
  /// For loops over the table: `T` must be the type of the series.
  template <typename T>
  std::span<T> Values(const Series& series) const {
    CDB_CHECK((series.type == SeriesType::kInt32) == std::is_integral_v<T>);
    const auto bytes = Find(series);
    return {reinterpret_cast<T*>(bytes.data()), bytes.size() / sizeof(T)};
  }
  /// Sets the value of a cycle, if the scene records the series.
  void Put(schema::IntSeries series, std::size_t cycle, std::int32_t value) {
    if (const auto values = Ints(series); !values.empty()) values[cycle] = value;
  }
  void Put(schema::RealSeries series, std::size_t cycle, double value) {
    if (const auto values = Reals(series); !values.empty()) values[cycle] = value;
  }
  /// The same for a series with a value for each type of query, which the cycles follow.
  void PutRow(schema::IntSeries series, std::size_t cycle,
              const std::array<std::int32_t, kQueryTypeCount>& row) {
    PutColumn(Ints(series), cycle, row);
  }
  void PutRow(schema::RealSeries series, std::size_t cycle,
              const std::array<double, kQueryTypeCount>& row) {
    PutColumn(Reals(series), cycle, row);
  }
  /// The values of the series as bytes.
  std::span<const std::byte> Bytes(const Series& series) const { return Find(series); }
  /// The run's samples, in the layout of SampleShapeOf the scene; empty if it requests no errors.
  std::span<double> SampleValues() const;

 private:
  Recording(int fd, const plan::Scene& scene, bool create);
  template <typename T>
  static void PutColumn(std::span<T> values, std::size_t cycle,
                        const std::array<T, kQueryTypeCount>& row) {
    const std::size_t cycles = values.size() / row.size();
    if (values.empty()) return;
    for (std::size_t i = 0; i < row.size(); ++i) values[i * cycles + cycle] = row[i];
  }
  /// `series`: an element of the table.
  std::span<std::byte> Find(const Series& series) const;

  int fd_ = -1;
  RecordingHeader* header_ = nullptr;
  std::size_t bytes_ = 0;
  struct Place {
    std::size_t offset = 0, bytes = 0;  ///< no bytes: not recorded
  };
  std::array<Place, std::size(schema::kSeries)> places_;  ///< in the order of the table
  std::size_t samples_offset_ = 0, samples_count_ = 0;
};

/// The worker's descriptors, set up by the process that starts it: one run as YAML to read, the
/// recording, and a file to which ContactRecords are appended (present even if the run records
/// none).
inline constexpr int kRunFd = 3;
inline constexpr int kRecordingFd = 4;
inline constexpr int kContactsFd = 5;
/// The trace to run the detector on (trace_memory.h); only if the run names one.
inline constexpr int kTraceFd = 6;
/// For a run without a trace: the poses that its groups take from HDF5 files (layouts::PackPoses);
/// only if there are any.
inline constexpr int kPosesFd = kTraceFd;
/// With kNarrowInputOption: a file for the input of the narrow phase (AppendNarrowInput).
inline constexpr int kNarrowInputFd = 7;
/// With `clock instructions`: the log of Valgrind, once for Valgrind to write and once for the
/// worker to read.
inline constexpr int kCountLogFd = 8, kCountsFd = 9;
/// The first argument of a worker that records the input of its narrow phase.
inline constexpr const char* kNarrowInputOption = "--narrow-input";
/// Option of the worker for a run that must keep components that it could omit: followed by their
/// names, separated by spaces, and by the reason.
inline constexpr const char* kKeepOption = "--keep";

// Records the function of a plug-in that a worker is executing, to report the place of a crash or
// hang.

enum class PluginCall : std::uint32_t {
  kNone,
  kLoad,
  kMake,
  kPrepare,
  kFindPairs,
  kHandles,
  kFindContacts,
  kDestroy
};

/// Encodes a call into the plug-in `index` of a scene; 0 for none.
std::uint32_t PluginCallCode(PluginCall call, std::size_t index);

/// `FindPairs of detector `mine` (libmine.so)`; empty for none, and for a code damaged by a crash.
std::string PluginCallText(std::uint32_t code, const plan::Scene& scene);

}  // namespace cdb::protocol
