// The figures of many results files of one project, in order of time, as series in which changes
// are found.
//
// Series are of one machine (model of the processor and kind of build) and of one scene: a run's
// settings, without the contents of plug-ins, which are what changes, and the repeats. Points are
// therefore matched also if axes were added, and never if the scene is another one, or if only one
// of them records counters.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/figures/history/change_points.h"
#include "runtime/results/store.h"

namespace cdb::history {

/// What is read of a point.
struct PointFigures {
  std::string place;  ///< `quantity 10, detector dbvt`; empty for a file with one point
  std::string scene;  ///< identifies its settings; empty for a plan that cannot be read
  std::map<std::string, double> figures;  ///< by name (kFigures), those that it has
  std::string state;                      ///< the hash of its last state; empty if unknown
  bool operator==(const PointFigures&) const = default;
};

/// What is read of a results file.
struct FileFigures {
  std::string file;  ///< its path in the folder
  std::string benchmark, title;
  double started = 0;  ///< the first run, s since 1970; 0 if unknown
  /// In its history: the time at which it was measured, or the index of its commit.
  double place = 0;
  std::map<std::string, std::string> facts;  ///< of provenance (kFacts), those that it has
  std::vector<PointFigures> points;          ///< those that are sound
  std::size_t unsound = 0;                   ///< number of points whose figures are not used
  bool has_counters = false;                 ///< as figures::HasCounters
  bool operator==(const FileFigures&) const = default;
};

/// A commit of the project.
struct Commit {
  std::string hash, subject;
  bool is_main = true;  ///< of the main line: the last one, its first parent, and so on
};

/// The names of PointFigures::figures.
enum class FigureKind {
  kTime,          ///< ns
  kInstructions,  ///< of a file that counts them
  kMemory,        ///< bytes
  kCount,         ///< without noise: any other value is a change of the motion
};
struct FigureInfo {
  const char* name;  ///< in files
  const char* text;  ///< for the output
  FigureKind kind;
};
inline constexpr FigureInfo kFigures[] = {
    {"step", "step", FigureKind::kTime},
    {"detect", "detect", FigureKind::kTime},
    {"broad", "broad", FigureKind::kTime},
    {"narrow", "narrow", FigureKind::kTime},
    {"step_instructions", "instructions of step", FigureKind::kInstructions},
    {"detect_instructions", "instructions of detect", FigureKind::kInstructions},
    {"broad_instructions", "instructions of broad", FigureKind::kInstructions},
    {"narrow_instructions", "instructions of narrow", FigureKind::kInstructions},
    {"peak_rss", "peak memory", FigureKind::kMemory},
    {"pairs", "pairs", FigureKind::kCount},
    {"contacts", "contacts", FigureKind::kCount},
};

/// When the first run of the file began, s since 1970; 0 if unknown.
double StartOf(const results::ResultFile& file);

/// `name`: of the file in the output. Throws StoreError.
FileFigures ReadFigures(const std::filesystem::path& path, const std::string& name);

struct Series {
  std::string place;
  const FigureInfo* figure;
  std::vector<std::size_t> files;  ///< indices in History::files, ascending
  std::vector<double> values;      ///< at each of `files`
  std::vector<Change> changes;     ///< their indices are of `files`
};

/// A change in History::series.
struct SeriesChange {
  std::size_t series, change;  ///< indices
};

/// Changes of one figure in a group.
struct FigureChange {
  const FigureInfo* figure;
  std::vector<SeriesChange> changes;
  double ratio, low, high;  ///< geometric mean over the series, with a 95 % interval
};

/// Changes of several series that happened together.
struct GroupedChange {
  bool is_drift;
  bool is_worse;                      ///< slower, or more memory
  std::size_t from, to;               ///< as of Change, in History::files
  std::vector<FigureChange> figures;  ///< in the order of kFigures
  std::vector<std::string> facts;     ///< of provenance that changed there: `compiler: a -> b`
};

/// Facts without noise that differ from one file to the next.
struct MotionChange {
  std::size_t from, to;
  std::vector<std::string> states;  ///< places with another last state
  std::vector<std::string> counts;  ///< places with other numbers of pairs or contacts
};

struct History {
  std::string machine, benchmark, title;
  std::vector<const FileFigures*> files;  ///< in order of their places, then of time
  std::vector<std::string> labels;        ///< of the files, all different
  std::vector<Series> series;
  std::vector<GroupedChange> changes;  ///< in order of `to`
  std::vector<MotionChange> motions;   ///< in order of `to`
  std::size_t short_series = 0;        ///< with too few files for a change
  std::size_t unrepeatable = 0;  ///< points with another motion in most files, in no MotionChange
  /// The factor of all changes of a series after the file `since`.
  double RatioSince(const Series& series, std::size_t since) const;
};

struct HistoryOptions {
  /// Changes of a ratio below this are not reported. By default, 1 % of times and memory, and 0.1 %
  /// of instructions, which have next to no noise.
  std::optional<double> least_effect = {};
  double significance = 0.001;
};

/// A history for each machine and benchmark, by their names. `files` must outlive them.
std::vector<History> MakeHistories(const std::vector<FileFigures>& files,
                                   const HistoryOptions& options);

}  // namespace cdb::history
