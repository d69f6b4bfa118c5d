// Traces on disk: the boxes of a recorded run as input of detectors, one HDF5 file for each run.
// `cdb doc traces` describes the file. The idea is from Broadmark (Serpa & Rodrigues, Computer
// Graphics Forum 39(1), 2020), which records scenes for broad phases.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "compiler/analysis/trace.h"
#include "runtime/measure/trace_memory.h"
#include "runtime/store/store.h"

namespace cdb::store {

inline constexpr std::string_view kTraceSchema = "cdb-trace";
inline constexpr int kTraceSchemaVersion = 1;

/// Where a trace is from.
struct TraceOrigin {
  std::string benchmark;
  std::string point;  ///< of the benchmark's grid, for people: `n 1000`; may be empty
  std::string run_id, state_hash;
  double timestep_s = 0;
  std::string scenario_text;
  std::string run_text;  ///< all that decides the run, as YAML
};

/// Writes `file`: under a temporary name, closed, fsynced, renamed. `poses` of `objects` bodies,
/// the first of the trace, as the series `poses` has them. Throws StoreError, with no file made or
/// changed.
void WriteTrace(const measure::TraceMemory& trace, const TraceOrigin& origin, std::uint64_t objects,
                std::span<const double> poses, const std::filesystem::path& file);

/// What the head of `file` says; the boxes are not read. Throws StoreError, which says why it is of
/// no use.
analysis::TraceFacts ReadTraceFacts(const std::filesystem::path& file);
/// The run that `file` is a trace of; nullopt where it is none that can be read.
std::optional<std::string> TracedRun(const std::filesystem::path& file);

/// What `cdb check` says of a trace whose every byte was read.
struct TraceCheck {
  bool has_digest = false;
  analysis::TraceFacts facts;
  std::string run_id;
};
/// Throws StoreError for a damaged one.
TraceCheck CheckTrace(const std::filesystem::path& file);

/// All of it. Throws StoreError, also where it does not hold what its hash says, or another trace
/// than `sha256`.
measure::TraceMemory LoadTrace(const std::filesystem::path& file, const std::string& sha256);

}  // namespace cdb::store
