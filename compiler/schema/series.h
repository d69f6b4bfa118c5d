// THE tables of series, the values that a run can record, most of them in each cycle, and of the
// scalars of a run. The checker, `cdb doc results`, the recording, the results and the names that
// an axis may have follow from them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace cdb::schema {

/// A word of `record`, which selects series.
struct RecordWord {
  std::string_view name;
  bool needs_detection = false;    ///< means nothing without broad and narrow phase
  bool on_traces = false;          ///< can be recorded by a detector that runs on a trace
  bool on_configurations = false;  ///< can be recorded of configurations, without a simulation
  bool on_soft = false;            ///< can be recorded of soft bodies
};

inline constexpr RecordWord kRecordWords[] = {
    {.name = "timing",
     .needs_detection = true,
     .on_traces = true,
     .on_configurations = true,
     .on_soft = true},
    {.name = "counters", .needs_detection = true, .on_traces = true, .on_soft = true},
    {.name = "counts",
     .needs_detection = true,
     .on_traces = true,
     .on_configurations = true,
     .on_soft = true},
    {.name = "energy", .on_soft = true},
    {.name = "stability", .on_soft = true},
    {.name = "contacts", .needs_detection = true, .on_configurations = true},
    {.name = "repose"},
    {.name = "poses", .on_configurations = true, .on_soft = true},
    {.name = "memory", .on_traces = true, .on_configurations = true, .on_soft = true},
    {.name = "pairs", .needs_detection = true, .on_traces = true, .on_configurations = true},
    {.name = "boxes", .needs_detection = true, .on_configurations = true},
    {.name = "queries"},
    {.name = "query_errors"},
    {.name = "vertices", .on_soft = true},
};

/// The phases of a cycle, in the order of the `phase` axis. Each is timed separately, in
/// nanoseconds.
enum class Phase { kBroad, kNarrow, kDetect, kSolve, kIntegrate, kStep };
inline constexpr std::string_view kPhases[] = {"broad", "narrow",    "detect",
                                               "solve", "integrate", "step"};
/// The events that `record counters` counts, in the order of the `counter` axis.
enum class Counter { kInstructions, kCpuCycles, kCacheMisses, kBranchMisses, kPageFaults };
inline constexpr std::string_view kCounters[] = {"instructions", "cpu_cycles", "cache_misses",
                                                 "branch_misses", "page_faults"};
inline constexpr std::string_view kPoseParts[] = {"x", "y", "z", "qx", "qy", "qz", "qw"};
inline constexpr std::string_view kBounds[] = {"lower_x", "lower_y", "lower_z",
                                               "upper_x", "upper_y", "upper_z"};
inline constexpr std::string_view kFilterParts[] = {"group", "mask", "fixed"};
/// The words of `queries.type`, in the order of the `query` axis.
enum class QueryType { kRay, kSweep, kOverlap, kNearest };
inline constexpr std::string_view kQueryTypes[] = {"ray", "sweep", "overlap", "nearest"};
inline constexpr std::string_view kCoordinates[] = {"x", "y", "z"};
inline constexpr std::string_view kAnswerParts[] = {"body", "distance", "normal_x", "normal_y",
                                                    "normal_z"};

/// A dimension of series in addition to the axes of the sweep.
enum class Dimension {
  kPhase,
  kCycle,
  kBody,
  kPose,
  kBoxBody,
  kBound,
  kFilter,
  kSample,
  kQuery,
  kQueryRow,
  kAnswer,
  kVertex,
  kCoordinate,
  kCounter
};

struct DimensionInfo {
  std::string_view name;
  std::string_view doc;                           ///< the coordinate's long_name
  std::span<const std::string_view> labels = {};  ///< empty if the extent depends on the run
  /// The unit of each label, separated by spaces; empty if the series has the same one for all.
  std::string_view units = {};
};

/// In the order of Dimension.
inline constexpr DimensionInfo kDimensions[] = {
    {.name = "phase", .doc = "part of a cycle that is timed", .labels = kPhases},
    {.name = "cycle", .doc = "recorded cycle"},
    {.name = "body", .doc = "object, in the order of its group and within it"},
    {.name = "pose",
     .doc = "centre of mass and orientation quaternion",
     .labels = kPoseParts,
     .units = "m m m 1 1 1 1"},
    {.name = "box_body", .doc = "object as of `body`, then the walls -x +x -y +y -z +z"},
    {.name = "bound", .doc = "side of a box", .labels = kBounds},
    {.name = "filter", .doc = "collision filter of a body", .labels = kFilterParts},
    {.name = "sample", .doc = "simulated time of a sample, warm-up included"},
    {.name = "query", .doc = "type of a query", .labels = kQueryTypes},
    {.name = "query_row", .doc = "query, in the order of its block and within it"},
    {.name = "answer",
     .doc = "part of the answer to a query",
     .labels = kAnswerParts,
     .units = "1 m 1 1 1"},
    {.name = "vertex", .doc = "node of a soft body, in the order of its object and within it"},
    {.name = "coordinate", .doc = "coordinate of a node", .labels = kCoordinates},
    {.name = "counter", .doc = "event of the processor or the system", .labels = kCounters},
};
constexpr const DimensionInfo& InfoOf(Dimension dimension) {
  return kDimensions[static_cast<std::size_t>(dimension)];
}

enum class SeriesType { kInt32, kFloat64 };

/// The runs on traces that record a series.
enum class OnTraces {
  kNone,
  kBroad,   ///< those of a broad phase on recorded boxes
  kNarrow,  ///< those of a narrow phase on recorded pairs
  kBoth,
  kNarrowOnly,  ///< as kNarrow, and no run in a live world
  kBroadOnly,   ///< as kBroad, and no run in a live world
};

/// Whether the runs that check configurations record a series.
enum class OnConfigurations {
  kNo,
  kYes,
  kOnly,  ///< and no other run
};

/// Whether the runs with soft bodies record a series.
enum class OnSoft {
  kNo,
  kYes,
  kOnly,  ///< and no other run
};

/// The dimensions of a series (DimensionsOf).
enum class SeriesShape {
  kScalar,  ///< a value for each cycle
  kPhase,
  kPose,
  kBox,
  kFilter,  ///< once per run
  kSample,  ///< errors, which are not part of a recording
  kQuery,   ///< a value for each type of query and each cycle
  kAnswer,
  kVertex,   ///< a position of each node of the soft bodies
  kCounter,  ///< a value for each counter, phase and cycle
};
std::span<const Dimension> DimensionsOf(SeriesShape shape);

/// Extents of one run, or the largest of all runs of a plan.
struct RunExtents {
  std::uint64_t cycles = 0;
  std::uint64_t objects = 0;
  std::uint64_t bodies = 0;   ///< objects, and the walls that are present
  std::uint64_t queries = 0;  ///< of all blocks
  std::uint64_t nodes = 0;    ///< of all soft bodies
};

struct Series {
  std::string_view name;     ///< name of the dataset
  std::string_view records;  ///< space-separated words of `record`, each of which selects it
  SeriesType type = SeriesType::kFloat64;
  SeriesShape shape = SeriesShape::kScalar;
  std::string_view unit = {};  ///< in the notation of results files; empty if there is none
  std::string_view doc;        ///< the dataset's long_name
  OnTraces on_traces = OnTraces::kNone;
  OnConfigurations on_configurations = OnConfigurations::kNo;
  OnSoft on_soft = OnSoft::kNo;
  bool may_be_none = false;  ///< NaN or infinite in a cycle without anything to measure
  bool of_queries = false;   ///< recorded only by runs with queries
  bool of_changes = false;   ///< recorded only by runs in which objects come or go

  std::size_t ItemBytes() const { return type == SeriesType::kInt32 ? 4 : 8; }
  /// The position of the cycle among its dimensions; nullopt if it has one value per run.
  std::optional<std::size_t> CycleDimension() const;
  bool HasCycles() const { return CycleDimension().has_value(); }
  /// The extent of each of its dimensions in a recording, outermost first.
  std::vector<std::uint64_t> Extents(const RunExtents& run) const;
  std::size_t ValueCount(const RunExtents& run) const;
};

namespace series_table {
using enum SeriesType;
using enum SeriesShape;
using enum OnTraces;
using enum OnConfigurations;
using Soft = OnSoft;
// clang-format off
inline constexpr auto kRows = std::to_array<Series>({
    {.name = "duration", .records = "timing", .shape = kPhase, .unit = "ns", .doc = "time of each phase of a cycle", .on_traces = kBoth, .on_configurations = kYes, .on_soft = Soft::kYes},
    {.name = "counters", .records = "counters", .shape = kCounter, .doc = "events of the thread in user mode, in each phase of a cycle; no value where the machine does not count them", .on_traces = kBoth, .on_soft = Soft::kYes, .may_be_none = true},
    {.name = "pairs", .records = "counts stability", .type = kInt32, .doc = "potentially colliding pairs of the broad phase", .on_traces = kBoth, .on_configurations = kYes, .on_soft = Soft::kYes},
    {.name = "manifolds", .records = "counts stability", .type = kInt32, .doc = "contact manifolds that hold a point", .on_traces = kNarrow, .on_configurations = kYes},
    {.name = "contacts", .records = "counts contacts stability", .type = kInt32, .doc = "contact points", .on_traces = kNarrow, .on_configurations = kYes, .on_soft = Soft::kYes},
    {.name = "unhandled_pairs", .records = "counts", .type = kInt32, .doc = "pairs of the trace that the narrow phase does not handle; they are not in its time, and Bullet makes their contacts", .on_traces = kNarrowOnly},
    {.name = "present", .records = "counts", .type = kInt32, .doc = "objects that are in the world in the cycle", .of_changes = true},
    {.name = "spawned", .records = "counts", .type = kInt32, .doc = "objects that came into the world just before the cycle", .of_changes = true},
    {.name = "departed", .records = "counts", .type = kInt32, .doc = "objects that left the world just before the cycle", .of_changes = true},
    {.name = "waiting", .records = "counts", .type = kInt32, .doc = "objects that were due in the cycle and found no free place", .of_changes = true},
    {.name = "change_time", .records = "timing", .unit = "ns", .doc = "time to add the objects that come before the cycle to the world, and to remove those that leave, which is not part of step; without finding places for them", .of_changes = true},
    {.name = "kinetic_energy", .records = "energy stability", .unit = "J", .doc = "kinetic energy of translation and rotation", .on_soft = Soft::kYes},
    {.name = "energy", .records = "energy stability", .unit = "J", .doc = "kinetic and potential energy, including springs and rotors, with the integrator's own term, dt F.v / 2, less the work of forces and torques, and of motors that give one", .on_soft = Soft::kYes},
    {.name = "max_penetration", .records = "stability", .unit = "m", .doc = "depth of the deepest contact; 0 if none overlaps; of soft bodies, that of the deepest node in a rigid body or wall", .on_soft = Soft::kYes},
    {.name = "penetration_ratio", .records = "stability", .doc = "depth of the deepest contact over the least side of the smaller object"},
    {.name = "max_speed", .records = "stability", .unit = "m/s", .doc = "highest speed of any object's centre of mass, or of any node of a soft body", .on_soft = Soft::kYes},
    {.name = "escaped", .records = "stability", .type = kInt32, .doc = "objects with their centre beyond a wall", .on_soft = Soft::kYes},
    {.name = "asleep", .records = "stability", .type = kInt32, .doc = "objects that Bullet has put to sleep"},
    {.name = "removed", .records = "stability", .type = kInt32, .doc = "objects that Bullet has switched off, or whose box it cannot hold", .on_soft = Soft::kYes},
    {.name = "non_finite", .records = "stability", .type = kInt32, .doc = "objects with a state that is not finite", .on_soft = Soft::kYes},
    {.name = "displacement", .records = "stability", .doc = "largest displacement of an object since the first cycle, over its least side"},
    {.name = "displaced", .records = "stability", .type = kInt32, .doc = "objects displaced since the first cycle by more than a quarter of their least side"},
    {.name = "motion_ratio", .records = "stability", .doc = "distance moved over the expected distance, |v| dt, since the object was last pushed, of the object where this is farthest from 1", .may_be_none = true},
    {.name = "fall_ratio", .records = "stability", .doc = "least gain of speed over that due to gravity, dv / (g dt), since the last contact", .may_be_none = true},
    {.name = "frozen", .records = "stability", .type = kInt32, .doc = "objects whose displacement or fall is off by more than a tenth, because of rounding"},
    {.name = "lost_way", .records = "stability", .doc = "largest distance that rounding added to or took from the motion of an object since it was last pushed, over its least side"},
    {.name = "turn_ratio", .records = "stability", .doc = "least angle turned over the expected angle, of the objects that rotate", .may_be_none = true},
    {.name = "spin_ratio", .records = "stability", .doc = "rotational energy over that before the first cycle, of the object without any contact since then for which this is farthest from 1", .may_be_none = true},
    {.name = "passed", .records = "stability", .type = kInt32, .doc = "objects that have passed through another one, or through a surface, since the first cycle; of two, the smaller that is free to move; beside soft bodies, rigid objects with a centre of mass over which a face of a cloth or block has moved", .on_soft = Soft::kYes},
    {.name = "unfollowed", .records = "stability", .type = kInt32, .doc = "pairs of objects of which it is not known whether they passed through each other in this cycle: they moved too far, or for too long within each other"},
    {.name = "pressed", .records = "stability", .type = kInt32, .doc = "pairs of bodies that a load presses into each other, by more than a quarter of the smaller one's least side"},
    {.name = "inverted", .records = "stability", .type = kInt32, .doc = "pairs of objects in which the object that lay on top is now below the other"},
    {.name = "unheld", .records = "stability", .type = kInt32, .doc = "objects asleep in the air or on a slope that does not hold them"},
    {.name = "lost_energy", .records = "stability", .doc = "energy lost, except to friction, inelastic bounces and sleep, over the largest kinetic energy so far and that of a small fall"},
    {.name = "gained_energy", .records = "stability", .doc = "the larger of two: energy gained, except from contacts that push objects out of each other, over the largest kinetic energy so far and that of a fall by a tenth of the sizes; energy by which rebounds exceed the restitution, over that of all approaches"},
    {.name = "false_normals", .records = "stability", .type = kInt32, .doc = "contacts with fixed ground that pushed along a normal that its shape does not allow"},
    {.name = "false_impulse", .records = "stability", .unit = "kg m/s", .doc = "impulse of these contacts across the legal normals, summed over the contacts"},
    {.name = "deflected", .records = "stability", .type = kInt32, .doc = "objects to which false normals have given more than a twentieth of their largest momentum so far"},
    {.name = "false_turn", .records = "stability", .unit = "rad", .doc = "largest angle by which an object that lay flat on fixed ground has turned on it so far, although friction cannot turn it"},
    {.name = "twisted", .records = "stability", .type = kInt32, .doc = "objects so far for which this angle is more than 0.1"},
    {.name = "friction_error", .records = "stability", .doc = "largest deviation so far of the change of velocity by friction from that by the coefficients of the scene, relative to it, of objects that slid flat on fixed ground", .may_be_none = true},
    {.name = "rolling_error", .records = "stability", .doc = "largest deviation of the speed at which a ball, cylinder or capsule rolls on a wall or a fixed cuboid, by its angular momentum about the line of contact, relative to its largest speed so far", .may_be_none = true},
    {.name = "impact_error", .records = "stability", .doc = "deviation of the impulses of impacts so far from those by the shapes, velocities and coefficients of the scene, relative to the sum of these", .may_be_none = true},
    {.name = "unjudged_impacts", .records = "stability", .type = kInt32, .doc = "impacts so far that were not compared"},
    {.name = "repose_angle", .records = "repose", .unit = "rad", .doc = "angle of repose: slope of the uniform cone on the floor that has the same mean height and mean distance from the axis as the objects that can move, each over the 95 % of the mass nearest to the axis", .may_be_none = true},
    {.name = "runout", .records = "repose", .unit = "m", .doc = "radius around the axis, vertical through the medians of x and z, that holds the centres of 95 % of the mass of the objects that can move", .may_be_none = true},
    {.name = "heap", .records = "memory", .unit = "bytes", .doc = "heap in use after the cycle", .on_traces = kBoth, .on_configurations = kYes, .on_soft = Soft::kYes},
    {.name = "joint_gap", .records = "stability", .unit = "m", .doc = "largest gap of a joint: distance of its two pivots, or of a slider past a limit or from where its gear puts it", .may_be_none = true},
    {.name = "joint_bend", .records = "stability", .unit = "rad", .doc = "largest angle by which joints give way: of a chain of fixed joints, the distance of an object from where the first one holds it, over the length between; of a hinge, that between its two axes, past a limit, or from where its gear puts it", .may_be_none = true},
    {.name = "joint_stretch", .records = "stability", .doc = "largest sum of the gaps of a chain of joints over its length", .may_be_none = true},
    {.name = "motor_error", .records = "stability", .doc = "largest deviation of the velocity of a motor from the one that it seeks, relative to it, or of its position, rad, or m over the least side, that the solver leaves although the motor has effort left", .may_be_none = true},
    {.name = "poses", .records = "poses vertices", .shape = kPose, .doc = "position and orientation quaternion (x, y, z, w) after the cycle: of the centre of mass and of the axes of the sides; of a mesh, of its origin and of the axes of its file; of a soft body, of the mean of its nodes, not turned", .on_configurations = kYes, .on_soft = Soft::kYes},
    {.name = "boxes", .records = "boxes", .shape = kBox, .unit = "m", .doc = "boxes passed to the broad phase in the cycle; the box of a plane is infinite, an omitted wall has none", .on_configurations = kYes, .may_be_none = true},
    {.name = "box_filters", .records = "boxes", .shape = kFilter, .doc = "bits of the group of the body and of the groups that it may collide with, and 1 if it is fixed; float64, as masks have 32 bits", .on_configurations = kYes},
    {.name = "stretch", .records = "stability", .doc = "largest length of a link of a soft body over its rest length, minus 1", .on_soft = Soft::kOnly},
    {.name = "inside", .records = "stability", .type = kInt32, .doc = "nodes of soft bodies deeper than their margin inside a rigid body, or behind a wall", .on_soft = Soft::kOnly},
    {.name = "self_crossings", .records = "stability", .type = kInt32, .doc = "links of cloths and blocks that pierce a triangle of the same body; no value without either", .on_soft = Soft::kOnly},
    {.name = "volume_ratio", .records = "stability", .doc = "volume of the tetrahedra of all blocks and soft( ) over that of the start; no value without them", .on_soft = Soft::kOnly, .may_be_none = true},
    {.name = "inverted_tetrahedra", .records = "stability", .type = kInt32, .doc = "tetrahedra of blocks and soft( ) that are flat or inside out; no value without them", .on_soft = Soft::kOnly},
    {.name = "momentum_error", .records = "stability", .doc = "change of the total momentum since the first cycle that gravity did not give, over the largest sum of the momenta of nodes and rigid bodies so far; no value with a pin, a fixed or kinematic body, a wall or damping", .on_soft = Soft::kOnly, .may_be_none = true},
    {.name = "vertex_positions", .records = "vertices", .shape = kVertex, .unit = "m", .doc = "position of each node of the soft bodies after the cycle", .on_soft = Soft::kOnly},
    {.name = "hit", .records = "timing counts pairs", .type = kInt32, .doc = "1 if the robot hits itself or the scene in this configuration, else 0", .on_configurations = kOnly},
    {.name = "self_hits", .records = "counts", .type = kInt32, .doc = "pairs of links that overlap; -1 if only a hit was asked for", .on_configurations = kOnly},
    {.name = "scene_hits", .records = "counts", .type = kInt32, .doc = "pairs of a link and an object, or wall, of the scene that overlap; -1 if only a hit was asked for", .on_configurations = kOnly},
    {.name = "least_distance", .records = "counts", .unit = "m", .doc = "least distance of two bodies that may touch, one of them a link; 0 if they overlap; only with configurations.ask distance", .on_configurations = kOnly, .may_be_none = true},
    {.name = "distance_error", .records = "pairs", .unit = "m", .doc = "difference of the least distance from that by geometry in double precision, with its proof", .on_configurations = kOnly, .may_be_none = true},
    {.name = "exact_hit", .records = "pairs", .type = kInt32, .doc = "1 if two bodies overlap by more than a ten thousandth of the size of the smaller one, 0 if none overlap, by geometry in double precision; -1 if neither is certain", .on_configurations = kOnly},
    {.name = "exact_pairs", .records = "pairs", .type = kInt32, .doc = "pairs that may collide and whose boxes overlap, by brute force in double precision", .on_traces = kBroad, .on_configurations = kYes},
    {.name = "missed_pairs", .records = "pairs", .type = kInt32, .doc = "exact pairs that the detector did not list", .on_traces = kBroad, .on_configurations = kYes},
    {.name = "phantom_pairs", .records = "pairs", .type = kInt32, .doc = "pairs that the detector listed although their boxes do not overlap", .on_traces = kBroad, .on_configurations = kYes},
    {.name = "duplicate_pairs", .records = "pairs", .type = kInt32, .doc = "pairs that the detector listed again", .on_traces = kBroad, .on_configurations = kYes},
    {.name = "exact_collisions", .records = "pairs", .type = kInt32, .doc = "exact pairs of a deforming mesh whose primitives meet: in a step in which each vertex moves along a line, or in the frame; without rounding; no value on the trace of a run", .on_traces = kBroadOnly, .may_be_none = true},
    {.name = "missed_collisions", .records = "pairs", .type = kInt32, .doc = "exact collisions of pairs that the detector did not list", .on_traces = kBroadOnly, .may_be_none = true},
    {.name = "exact_contacts", .records = "pairs", .type = kInt32, .doc = "overlaps deeper than a ten thousandth of the size of the smaller object, by geometry in double precision", .on_traces = kNarrow, .on_configurations = kYes},
    {.name = "uncompared_contacts", .records = "pairs", .type = kInt32, .doc = "other pairs that may overlap as deeply: the exact depth is not proven, or the cycle has too many and they were not drawn", .on_traces = kNarrow, .on_configurations = kYes},
    {.name = "missed_contacts", .records = "pairs", .type = kInt32, .doc = "exact contacts that the narrow phase did not make", .on_traces = kNarrow, .on_configurations = kYes},
    {.name = "unlisted_contacts", .records = "pairs", .type = kInt32, .doc = "exact contacts of pairs that the broad phase did not list, which are missed, too", .on_traces = kNarrow, .on_configurations = kYes},
    {.name = "bullet_contacts", .records = "pairs", .type = kInt32, .doc = "exact contacts of pairs whose contacts Bullet makes, not the detector", .on_traces = kNarrow, .on_configurations = kYes},
    {.name = "bullet_missed_contacts", .records = "pairs", .type = kInt32, .doc = "missed contacts of these pairs", .on_traces = kNarrow, .on_configurations = kYes},
    {.name = "bullet_uncompared_contacts", .records = "pairs", .type = kInt32, .doc = "uncompared contacts of pairs whose contacts Bullet makes", .on_traces = kNarrow, .on_configurations = kYes},
    {.name = "false_contacts", .records = "pairs", .type = kInt32, .doc = "pairs with a contact deeper than a thousandth of the size of the smaller object, although they do not overlap", .on_traces = kNarrow, .on_configurations = kYes},
    {.name = "depth_error", .records = "pairs", .doc = "mean error of the depth of exact contacts, in sizes of the smaller object", .on_traces = kNarrow, .on_configurations = kYes, .may_be_none = true},
    {.name = "max_depth_error", .records = "pairs", .doc = "largest error of the depth of an exact contact, in sizes of the smaller object", .on_traces = kNarrow, .on_configurations = kYes, .may_be_none = true},
    {.name = "normal_error", .records = "pairs", .unit = "rad", .doc = "mean error of the normals of exact contacts", .on_traces = kNarrow, .on_configurations = kYes, .may_be_none = true},
    {.name = "max_normal_error", .records = "pairs", .unit = "rad", .doc = "largest error of the normal of an exact contact", .on_traces = kNarrow, .on_configurations = kYes, .may_be_none = true},
    {.name = "query_time", .records = "timing", .shape = kQuery, .unit = "ns", .doc = "time of all queries of a type in a cycle, which is not part of step; 0 in a cycle without any", .of_queries = true},
    {.name = "query_update_time", .records = "timing", .unit = "ns", .doc = "time to build or refit cdb's own tree for the queries of a cycle; 0 without it", .of_queries = true},
    {.name = "query_count", .records = "counts", .type = kInt32, .shape = kQuery, .doc = "queries of a type in the cycle", .of_queries = true},
    {.name = "query_hits", .records = "counts", .type = kInt32, .shape = kQuery, .doc = "bodies that these queries found", .of_queries = true},
    {.name = "answers", .records = "queries", .shape = kAnswer, .doc = "the first hit of each query: index of the body (the walls -x +x -y +y -z +z follow the last object), distance along the ray or to the body, unit normal of the body; no value: no hit, or not asked in this cycle", .may_be_none = true, .of_queries = true},
    {.name = "compared_queries", .records = "query_errors", .type = kInt32, .shape = kQuery, .doc = "queries compared with an exact answer, by brute force in double precision; the others only graze a body", .of_queries = true},
    {.name = "missed_hits", .records = "query_errors", .type = kInt32, .shape = kQuery, .doc = "compared queries that did not find a body, or found one behind it", .of_queries = true},
    {.name = "false_hits", .records = "query_errors", .type = kInt32, .shape = kQuery, .doc = "compared queries that found a body where there is none", .of_queries = true},
    {.name = "hit_error", .records = "query_errors", .shape = kQuery, .unit = "m", .doc = "largest error of the distance of the other hits", .may_be_none = true, .of_queries = true},
    {.name = "hit_normal_error", .records = "query_errors", .shape = kQuery, .unit = "rad", .doc = "largest error of the normal of the other hits, where the body has one", .may_be_none = true, .of_queries = true},
});
// clang-format on
}  // namespace series_table
inline constexpr const auto& kSeries = series_table::kRows;

/// Null if there is none.
const Series* FindSeries(std::string_view name);

/// Not constexpr: a constant expression that calls one of these does not compile, and the error
/// message shows its name.
void NoSuchSeries();
void SeriesHasAnotherType();

/// A series named in the code: `recording.Ints("pairs")`. It is a compile error if the table has no
/// such name, or if its values are of another type.
template <typename T>
class SeriesRef {
  static_assert(std::is_same_v<T, std::int32_t> || std::is_same_v<T, double>);

 public:
  /// Implicit, so that `recording.Ints("pairs")` can be written.
  consteval SeriesRef(const char* name) {
    while (row_ < kSeries.size() && kSeries[row_].name != name) ++row_;
    if (row_ == kSeries.size()) NoSuchSeries();
    if ((kSeries[row_].type == SeriesType::kInt32) != std::is_same_v<T, std::int32_t>)
      SeriesHasAnotherType();
  }

  constexpr const Series& operator*() const { return kSeries[row_]; }
  constexpr std::string_view name() const { return kSeries[row_].name; }

 private:
  std::size_t row_ = 0;
};
using IntSeries = SeriesRef<std::int32_t>;
using RealSeries = SeriesRef<double>;

// THE table of scalars that a worker measures once per run.

/// NaN if the run did not get that far.
struct RunScalars {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double peak_rss_bytes = kNone;  ///< of the worker process
  double place_ns = kNone;        ///< placing the objects
  double build_ns = kNone;        ///< deciding the omissions and building the world
  /// Overhead of a cycle: its clock stamps and a call of a detector that does nothing.
  double harness_ns = kNone;
  double fill_fraction = kNone;  ///< objects' volume over the cube's
  // For all recorded cycles, including the measurements between them.
  double cycles_wall_ns = kNone, cycles_cpu_ns = kNone;
  double preemptions = kNone;  ///< involuntary context switches of the thread
  double page_faults = kNone;  ///< of the thread
  double stolen_ns = kNone;    ///< taken by other virtual machines, summed over all processors
  double others_ns = kNone;    ///< processor time of other programs, summed over all processors
  double processors = kNone;   ///< number that the process may run on
  /// Set by the runner: the number of times that the run was measured; the quietest one is kept.
  double attempts = kNone;
  // Set by the runner, from the recording of a run that records stability.
  double moving_objects = kNone;
  double mean_asleep = kNone;  ///< number of objects asleep, the mean over cycles
};

struct RunScalarInfo {
  std::string_view name;  ///< name of the array in the results
  std::string_view unit = {};
  std::string_view doc;  ///< the array's long_name
  double RunScalars::*value;
  bool is_count = false;  ///< stored as int32 in the results
  bool by_clock = false;  ///< in the unit of the scene's `clock`
};

// clang-format off
inline constexpr RunScalarInfo kRunScalars[] = {
    {.name = "peak_rss", .unit = "bytes", .doc = "peak memory of the run's process, once the objects are made", .value = &RunScalars::peak_rss_bytes},
    {.name = "place_time", .unit = "ns", .doc = "time to place the objects", .value = &RunScalars::place_ns, .by_clock = true},
    {.name = "build_time", .unit = "ns", .doc = "time to decide the omissions and build the world", .value = &RunScalars::build_ns, .by_clock = true},
    {.name = "harness", .unit = "ns", .doc = "measurement overhead of a cycle: time stamps, and calling a detector that does nothing", .value = &RunScalars::harness_ns, .by_clock = true},
    {.name = "fill_fraction", .doc = "volume of the objects over that of the world", .value = &RunScalars::fill_fraction},
    {.name = "cycles_time", .unit = "ns", .doc = "wall-clock time of the recorded cycles, with what is measured between them", .value = &RunScalars::cycles_wall_ns},
    {.name = "cpu_time", .unit = "ns", .doc = "of cycles_time, the time that the thread spent on a processor", .value = &RunScalars::cycles_cpu_ns},
    {.name = "preemptions", .doc = "how often the thread was taken off its processor meanwhile", .value = &RunScalars::preemptions, .is_count = true},
    {.name = "page_faults", .doc = "page faults of the thread meanwhile", .value = &RunScalars::page_faults, .is_count = true},
    {.name = "steal", .unit = "ns", .doc = "processor time taken by other virtual machines meanwhile, of all processors", .value = &RunScalars::stolen_ns},
    {.name = "other_time", .unit = "ns", .doc = "processor time of other programs meanwhile, of all processors", .value = &RunScalars::others_ns},
    {.name = "processors", .doc = "processors that the run was allowed to use", .value = &RunScalars::processors, .is_count = true},
    {.name = "attempts", .doc = "times that the run was measured, of which the quietest is kept", .value = &RunScalars::attempts, .is_count = true},
    {.name = "moving_objects", .doc = "objects that are neither fixed nor kinematic", .value = &RunScalars::moving_objects, .is_count = true},
    {.name = "mean_asleep", .doc = "objects asleep, the mean over the cycles", .value = &RunScalars::mean_asleep},
};
// clang-format on

}  // namespace cdb::schema
