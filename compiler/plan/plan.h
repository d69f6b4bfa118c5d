// The plan: every run of a benchmark, spelled out. The whole contract between compiler, runner and
// worker.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "compiler/plan/settings.h"
#include "compiler/schema/plugins.h"
#include "compiler/schema/value.h"

namespace cdb::plan {

/// Raised with every other plan format than this one. Part of every run's id.
inline constexpr int kPlanVersion = 5;

/// One `objects` group of a run.
struct Group {
  std::string name;  ///< `objects` where the file gives none
  GroupSettings settings;
  /// It has objects, and `links.type` holds them together.
  bool HasLinks() const;
  bool operator==(const Group&) const = default;
};

/// What a run is for. Only measured runs stand on the grid; the others say what is true
/// (compiler/reference.h).
enum class Role { kMeasured, kReference, kPerturbed };

/// In plans: `measured`, `reference`, `twin`.
std::string_view RoleName(Role role);

/// All that decides a run's result.
struct Scene {
  Role role = Role::kMeasured;
  WorldSettings world;        ///< every parameter that is not of a group
  std::vector<Group> groups;  ///< at least one
  /// The seed of every stream of random numbers, by its name: `objects.location`, `pebbles.size`,
  /// `acceleration`. A stream is listed for each distribution the scene draws from; 64 bits,
  /// derived from `seed` by `StreamSeed`.
  std::map<std::string, std::uint64_t, std::less<>> seeds;
  /// The detectors of plug-ins that the settings name, in the order of their names.
  std::vector<schema::PluginDetector> plugins;

  /// Objects of all groups together, walls not counted.
  std::uint64_t ObjectCount() const;
  /// Some setting names this detector.
  bool Uses(std::string_view detector) const;
  /// Drops the plug-ins that no setting names: what decides nothing must not make another run.
  void KeepUsedPlugins();
  bool operator==(const Scene&) const = default;
};

/// splitmix64 over FNV-1a: the seed of the stream `name` under the benchmark's `seed`.
std::uint64_t StreamSeed(std::uint64_t seed, std::string_view name);

/// A coordinate on an axis: numbers are numbers, anything else is its `.cdb` text.
using Coordinate = std::variant<double, std::string>;
/// As hashes of plans have it.
std::string CoordinateText(const Coordinate& coordinate);

struct Axis {
  std::string name;                ///< `quantity`, `aspect_z`
  std::string parameter;           ///< `objects.quantity`, or empty (a `let` or `cases`)
  std::string unit;                ///< of its values, as the schema says; may be empty
  std::vector<Coordinate> values;  ///< all numbers or all text
  bool IsText() const { return !values.empty() && values[0].index() == 1; }
  /// Every value is a whole number that an int32 holds.
  bool IsInteger() const;
  bool operator==(const Axis&) const = default;
};

/// One point of the grid in one repeat.
struct Run {
  std::string id;  ///< 16 hex digits of a hash of `scene`, `rep` and kPlanVersion; the shard's name
  std::vector<std::size_t> at;  ///< the index on each axis; empty for a reference
  std::uint64_t rep = 0;
  Scene scene;
  /// Ids of the plan's references that it is compared with; empty where there are none, and in a
  /// run that was read by itself.
  std::string reference, perturbed;
  bool operator==(const Run&) const = default;
};

/// Of a plan that is too long to be listed: what the parts of it must know.
struct WholePlan {
  using VisitRun = std::function<void(const std::string& id, const std::vector<std::size_t>& at,
                                      std::uint64_t rep)>;
  using VisitPoint = std::function<void(const std::vector<std::size_t>& at)>;

  std::string sha256;
  std::uint64_t run_count = 0;
  /// Runs of it: the most cycles, objects, bodies and samples of any run are those of one of these,
  /// and what some run records or asks for, one of these does.
  std::vector<Run> bounds;
  std::string short_text;                             ///< as YAML (compiler/yaml/short_plan.h)
  std::function<void(const VisitRun&)> for_each_run;  ///< in grid order
  std::function<void(const VisitPoint&)> for_each_skipped;  ///< in grid order
};

struct Plan {
  std::string benchmark;      ///< its name; decides the result file's
  std::string title;          ///< the text after the name; may be empty
  std::string source;         ///< the scenario file, as the user named it
  std::string scenario_text;  ///< that file's text, and of the files it uses
  std::vector<Axis> axes;     ///< the first varies slowest; may be empty (one run)
  std::uint64_t repeats = 1;
  std::vector<Run> runs;                          ///< in grid order, repeats innermost
  std::vector<std::vector<std::size_t>> skipped;  ///< points that `skip` left out, in grid order
  /// Reference runs and their perturbed runs, each once; they follow from `runs` (AddReferences).
  std::vector<Run> references;
  /// Where it is not null, `runs` are some of its runs, and `skipped` is empty.
  std::shared_ptr<const WholePlan> whole;

  /// What holds of these, as of WholePlan::bounds, holds of all runs.
  const std::vector<Run>& Bounds() const { return whole ? whole->bounds : runs; }
  /// Of all runs and skipped points, listed or not.
  std::uint64_t RunCount() const { return whole ? whole->run_count : runs.size(); }
  void ForEachRun(const WholePlan::VisitRun& visit) const;
  void ForEachSkipped(const WholePlan::VisitPoint& visit) const;

  /// 64 hex digits over axes, repeats, runs and skipped points: what decides the results. Title,
  /// source and text do not. That of `whole` where there is one.
  std::string Sha256() const;
  /// The most cycles, objects of any run: the extent of the result's `cycle` and `body`.
  std::uint64_t MaxCycles() const;
  std::uint64_t MaxObjects() const;
  /// Some run records it (`record energy`).
  bool Records(std::string_view what) const;
  bool operator==(const Plan&) const = default;
};

/// `16 hex digits` for a run; see Run::id.
std::string RunId(const Scene& scene, std::uint64_t rep);
/// The same of the text that it is the hash of: the scene's settings, a line each, and its
/// CanonicalTail.
std::string RunIdOf(std::uint64_t rep, std::string_view canonical);
/// The lines of seeds and plug-ins.
std::string CanonicalTail(const Scene& scene);

/// `quantity 1000, detector dbvt, rep 0`: a run's place, for people; `reference 0123…` for one that
/// has none.
std::string Describe(const Plan& plan, const Run& run);

}  // namespace cdb::plan
