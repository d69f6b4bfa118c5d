// Traces on disk: the boxes of a recorded run as input of detectors, and, if asked, its poses and
// pairs as input of narrow phases, one HDF5 file for each run.
// `cdb doc traces` describes the file. The idea is from Broadmark (Serpa & Rodrigues, Computer
// Graphics Forum 39(1), 2020), which records scenes for broad phases.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "compiler/analysis/trace.h"
#include "runtime/protocol/trace_memory.h"
#include "runtime/results/store.h"

namespace cdb::results {

inline constexpr std::string_view kTraceSchema = "cdb-trace";
inline constexpr int kTraceSchemaVersion = 1;

/// The origin of a trace.
struct TraceOrigin {
  std::string benchmark;
  std::string point;  ///< of the benchmark's grid, for display: `n 1000`; may be empty
  std::string run_id, state_hash;
  double timestep_s = 0;
  std::string scenario_text;
  std::string run_text;  ///< everything that determines the run, as YAML; as in a trace of pairs
  /// Of a deforming mesh, which has no scenario and no run: the files of its frames, one a line.
  std::string frame_files = {};
};

/// Writes `file`: under a temporary name, closed, synced, renamed. `poses`: of the first `objects`
/// bodies of the trace, in the layout of the series `poses`. Throws StoreError, with no file
/// created or changed.
void WriteTrace(const protocol::TraceMemory& trace, const TraceOrigin& origin,
                std::uint64_t objects, std::span<const double> poses,
                const std::filesystem::path& file);

/// The facts in the head of `file`; the boxes are not read. Throws StoreError with the reason if it
/// cannot be used.
analysis::TraceFacts ReadTraceFacts(const std::filesystem::path& file);
/// The id of the run that `file` is a trace of; nullopt if it is not a readable trace.
std::optional<std::string> TracedRun(const std::filesystem::path& file);

/// The output of `cdb check` for a trace whose every byte was read.
struct TraceCheck {
  bool has_digest = false;
  analysis::TraceFacts facts;
  std::string run_id;
};
/// Throws StoreError for a damaged trace.
TraceCheck CheckTrace(const std::filesystem::path& file);

/// Reads the trace that a plan names by `sha256`: that of its boxes, or that of its pairs, which
/// reads both. Throws StoreError, also if its contents do not match its hash, or if it is not that
/// trace.
protocol::TraceMemory LoadTrace(const std::filesystem::path& file, const std::string& sha256);

}  // namespace cdb::results
