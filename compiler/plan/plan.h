// The plan: every run of a benchmark in full. The only contract between compiler, runner and
// worker.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "compiler/plan/race.h"
#include "compiler/plan/requirement.h"
#include "compiler/plan/settings.h"
#include "compiler/schema/catalogue.h"
#include "compiler/schema/value.h"

namespace cdb::plan {

/// Incremented with every change of the plan format, but not for a new parameter or a changed
/// default (schema::Parameter). Part of every run's id.
inline constexpr int kPlanVersion = 6;
/// The oldest format that is still read. Format 5 listed every parameter, and its ids were hashes
/// of all of them.
inline constexpr int kOldestPlanVersion = 5;

/// One `objects` group of a run.
struct Group {
  std::string name;  ///< `objects` if the file gives no name
  GroupSettings settings;
  /// True if it has objects that `links.type` holds together.
  bool HasLinks() const;
  bool operator==(const Group&) const = default;
};

/// The name of the world among those of groups, in a joint.
inline constexpr std::string_view kWorldWord = "world";

/// One `joints` block of a run: joints between the objects of two groups.
struct Joint {
  std::string name;  ///< `joints` if the file gives no name
  GroupSettings settings;
  bool operator==(const Joint&) const = default;
};

/// One `queries` block of a run: rays, or shapes, for which bodies are found in each cycle.
struct Queries {
  std::string name;  ///< `queries` if the file gives no name
  GroupSettings settings;
  bool operator==(const Queries&) const = default;
};

/// The purpose of a run. Only measured runs are on the grid; the others provide the ground truth
/// (compiler/analysis/reference.h).
enum class Role { kMeasured, kReference, kTwin };

/// In plans: `measured`, `reference`, `twin`.
std::string_view RoleName(Role role);

/// Everything that determines the result of a run.
struct Scene {
  Role role = Role::kMeasured;
  WorldSettings world;        ///< every parameter that does not belong to a group
  std::vector<Group> groups;  ///< at least one
  std::vector<Joint> joints;
  std::vector<Queries> queries;
  /// The seed of every stream of random numbers, by its name: `objects.location`, `pebbles.size`,
  /// `acceleration`. There is a stream for each distribution that the scene draws from; 64 bits,
  /// derived from `seed` by `StreamSeed`.
  std::map<std::string, std::uint64_t, std::less<>> seeds;
  /// The plug-in detectors that the settings name, ordered by name.
  std::vector<schema::PluginDetector> plugins;

  /// Null for `world`, and for names that are no group.
  const Group* FindGroup(std::string_view name) const;
  /// True if both sides of the joint have objects; the world counts as one.
  bool HoldsObjects(const Joint& joint) const;
  /// The name of the first group whose objects links or joints pull; empty if there is none.
  std::string PulledGroup() const;
  /// Objects of all groups together, excluding walls.
  std::uint64_t ObjectCount() const;
  /// Queries of all blocks together, in a cycle in which all of them are asked.
  std::uint64_t QueryCount() const;
  /// Removes the queries and their seeds, which a derived scene does not ask.
  void DropQueries();
  /// True if a setting names this detector.
  bool Uses(std::string_view detector) const;
  /// Drops unused plug-ins: they have no effect, so they must not change the id of the run.
  void KeepUsedPlugins();
  bool operator==(const Scene&) const = default;
};

/// splitmix64 over FNV-1a: the seed of the stream `name` under the benchmark's `seed`.
std::uint64_t StreamSeed(std::uint64_t seed, std::string_view name);

/// A coordinate on an axis: a number, or the `.cdb` text of any other value.
using Coordinate = std::variant<double, std::string>;
/// As it enters the hash of a plan.
std::string CoordinateText(const Coordinate& coordinate);

/// What varies along an axis of sampled points.
struct Coordinates {
  std::string name;            ///< of the let
  double first = 0, last = 0;  ///< of its range
  bool is_log = false;         ///< sampled evenly in its logarithm
  std::vector<double> values;  ///< of each point
  bool operator==(const Coordinates&) const = default;
};

/// The search along an axis for the first value at which a condition on the results holds. All
/// values have runs in the plan; those that the search does not need are not executed.
struct Search {
  Requirement until;
  bool is_log = false;  ///< the values are evenly spaced in their logarithm
  bool operator==(const Search&) const = default;
};

struct Axis {
  std::string name;                       ///< `quantity`, `aspect_z`
  std::string parameter;                  ///< `objects.quantity`, or empty (a `let` or `cases`)
  std::string unit;                       ///< of its values, from the schema; may be empty
  std::vector<Coordinate> values;         ///< all numbers or all text
  std::string title = {};                 ///< of a figure's axis, from `as "title"`; may be empty
  std::vector<Coordinates> sampled = {};  ///< if its values are the numbers of sampled points
  std::optional<Search> search = {};      ///< of `find( )`: its values ascend or descend
  std::optional<Race> race = {};          ///< of `race( )`; the same on all axes that have one
  bool IsText() const { return !values.empty() && values[0].index() == 1; }
  /// True if its values are numbers of something that may be more or less.
  bool IsScale() const { return !IsText() && sampled.empty(); }
  /// True if every value is an integer that fits into an int32.
  bool IsInteger() const;
  bool operator==(const Axis&) const = default;
};

/// The index of the axis with a search; nullopt if there is none.
std::optional<std::size_t> SearchAxis(std::span<const Axis> axes);
/// The indices of the axes with a race.
std::vector<std::size_t> RaceAxes(std::span<const Axis> axes);
/// True if the results of some runs decide which others are executed: of a search or a race.
bool ChoosesRuns(std::span<const Axis> axes);

/// One point of the grid in one repeat.
struct Run {
  std::string id;               ///< 16 hex digits of a hash of `scene`, `rep` and kPlanVersion
  std::vector<std::size_t> at;  ///< the index on each axis; empty for a reference
  std::uint64_t rep = 0;
  Scene scene;
  /// Ids of the plan's references that it is compared with; empty where there are none, and in a
  /// run that was read by itself.
  std::string reference, twin;
  bool operator==(const Run&) const = default;
};

/// The data that parts of a plan need if the plan is too long to be listed.
struct WholePlan {
  using VisitRun = std::function<void(const std::string& id, const std::vector<std::size_t>& at,
                                      std::uint64_t rep)>;
  using VisitPoint = std::function<void(const std::vector<std::size_t>& at)>;

  std::string sha256;
  std::uint64_t run_count = 0;
  /// Runs that bound all others: they include the maximum of cycles, objects, bodies and samples,
  /// and everything that any run records or requests.
  std::vector<Run> bounds;
  std::string short_text;                             ///< as YAML (compiler/yaml/short_plan.h)
  std::function<void(const VisitRun&)> for_each_run;  ///< in grid order
  std::function<void(const VisitPoint&)> for_each_skipped;  ///< in grid order
};

struct Plan {
  int version = kPlanVersion;  ///< of the format of its ids
  std::string benchmark;       ///< its name, which determines that of the result file
  std::string title;           ///< the text after the name; may be empty
  std::string source;          ///< the scenario file, as the user named it
  std::string scenario_text;   ///< the text of this file, and of the files it uses
  std::vector<Axis> axes;      ///< the first varies slowest; may be empty (one run)
  std::uint64_t repeats = 1;
  std::optional<double> budget_s;                 ///< that a step, or a frame, may take
  std::optional<double> frame_s;                  ///< that the steps within the budget make up
  std::vector<Requirement> requirements;          ///< `require`; without the budget
  std::vector<Run> runs;                          ///< in grid order, repeats innermost
  std::vector<std::vector<std::size_t>> skipped;  ///< points that `skip` left out, in grid order
  /// Reference runs and their twins, each once; they follow from `runs` (AddReferences).
  std::vector<Run> references;
  /// If not null, `runs` are some of its runs, and `skipped` is empty.
  std::shared_ptr<const WholePlan> whole;

  /// Runs that bound all others, as WholePlan::bounds does.
  const std::vector<Run>& Bounds() const { return whole ? whole->bounds : runs; }
  std::optional<std::size_t> SearchAxis() const { return plan::SearchAxis(axes); }
  std::vector<std::size_t> RaceAxes() const { return plan::RaceAxes(axes); }
  bool ChoosesRuns() const { return plan::ChoosesRuns(axes); }
  /// The number of all runs, or skipped points, listed or not.
  std::uint64_t RunCount() const { return whole ? whole->run_count : runs.size(); }
  void ForEachRun(const WholePlan::VisitRun& visit) const;
  void ForEachSkipped(const WholePlan::VisitPoint& visit) const;

  /// 64 hex digits, a hash of axes, repeats, runs and skipped points, which determine the results;
  /// titles, source, text, budget, frame and requirements are excluded. That of `whole` if there
  /// is one.
  std::string Sha256() const;
  /// Gives a plan that was read from an earlier format the ids of this one.
  void Renew();
  /// The maximum of cycles, or objects, of any run: the extent of `cycle`, or `body`, in the
  /// results.
  std::uint64_t MaxCycles() const;
  std::uint64_t MaxObjects() const;
  /// True if a run records `what` (`record energy`).
  bool Records(std::string_view what) const;
  bool operator==(const Plan&) const = default;
};

/// 16 hex digits for a run; see Run::id.
std::string RunId(const Scene& scene, std::uint64_t rep);
/// The same, from the text that is hashed: the CanonicalLines of world, role and groups, followed
/// by the CanonicalTail.
std::string RunIdOf(std::uint64_t rep, std::string_view canonical, int version = kPlanVersion);
/// `timestep 0.01`, a line.
std::string CanonicalLine(std::string_view name, const schema::Value& value);
/// `role reference`, a line; empty for a measured run.
std::string CanonicalLine(Role role);
/// The lines of seeds and plug-ins.
std::string CanonicalTail(const Scene& scene);

/// `quantity 1000, detector dbvt, rep 0`: the position of a run, for messages; `reference 0123…`
/// for a run without one.
std::string Describe(const Plan& plan, const Run& run);

// Coordinates on axes as readable text. Plans and results hold the numbers themselves.

/// A value on an axis, in full if it is an integer or has at most six significant digits: 0.0125.
/// Other values are rounded to four digits, or to the number that distinguishes them from all other
/// values of the axis: 1/60 is 0.01667, 0.30000000000000004 is 0.3. Two different values never have
/// the same label.
std::string CoordinateLabel(const Axis& axis, std::size_t index);

/// The labels of all values; faster than separate calls.
std::vector<std::string> CoordinateLabels(const Axis& axis);

/// A number as CoordinateLabel formats it on an axis with no other value.
std::string ShortReal(double value);

}  // namespace cdb::plan
