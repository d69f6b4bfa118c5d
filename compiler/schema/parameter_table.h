// The rows of THE table of parameters, as constants, so that a name in the code is looked up at
// compile time (parameter_ref.h). At run time, use schema.h.
#pragma once

#include <array>

#include "compiler/schema/schema.h"

namespace cdb::schema {

/// A class, so that the short names of the table are local to it.
struct ParameterTable {
  using enum ParameterType;
  using enum WordSource;
  static constexpr double kMaxSeed = 18446744073709551615.0;
  static constexpr Domain kAny = {};
  static constexpr Domain kPositive = {.min = 0, .min_open = true};
  static constexpr Domain kNotNegative = {.min = 0};
  static constexpr Domain kFraction = {.min = 0, .max = 1};
  /// Cycles, objects and repeats are int32 coordinates of the results.
  static constexpr Domain kCountFromOne = {.min = 1, .max = 2147483647};
  static constexpr Domain kCountFromZero = {.min = 0, .max = 2147483647};
  static constexpr bool kGroup = true;
  static constexpr bool kDrawn = true;
  static constexpr bool kConstant = false;

  // clang-format off
  static constexpr auto kRows = std::to_array<Parameter>({
    // The ten parameters of the paper, section 3.1.
    {"cycles", false, kCount, kCountFromOne, kConstant, "", "1000", "", kOwn,
     "collision-detection cycles to time",
     "steps frames iterations duration"},
    {"quantity", kGroup, kCount, kCountFromZero, kConstant, "", "10", "", kOwn,
     "number of objects",
     "count number n amount objects"},
    {"type", kGroup, kWord, kAny, kDrawn, "", "sphere", "", kObjectTypes,
     "shape of the objects",
     "kind shape shapes object types", "mesh hull surface heights"},
    {"aspect", kGroup, kRatio, kPositive, kConstant, "", "1 : 1 : 1", "", kOwn,
     "ratio of the sides, 1 : y : z; a side is size times its part: the full extent along x, y or z; at 1 : 1 : 1 a mesh keeps its proportions, and its longest side is the size"},
    {"location", kGroup, kWord, kAny, kConstant, "", "uniform", "", kLayouts,
     "layout of the objects; they do not overlap unless `overlap` permits it",
     "position layout placement distribution", "grid stack pyramid pile ring line at pair poses path"},
    {"overlap", kGroup, kSwitch, kAny, kConstant, "", "off", "", kOwn,
     "permits initial overlaps with objects of every group that also has it on, if a layout with arguments yields them",
     "overlapping"},
    {"collides_with", kGroup, kWords, kAny, kConstant, "", "all", "all none", kGroups,
     "the groups, and walls, that the objects may touch; two groups touch only if each one allows the other",
     "collision_group collision_mask collide_bitmask contype conaffinity filter layer", "", true},
    {"size", kGroup, kReal, kPositive, kDrawn, "m", "50", "", kOwn,
     "full extent of an object; a distribution draws each side separately, same( ) draws one value for all sides",
     "radius diameter length extent scale", "same"},
    {"mass", kGroup, kReal, kPositive, kDrawn, "kg", "1", "fixed kinematic", kOwn,
     "mass of an object, or density( ) to compute it from the volume; fixed objects never move, kinematic objects follow their velocities or path whatever they meet",
     "weight density", "density"},
    {"acceleration", false, kVector, kAny, kDrawn, "m/s^2", "(0, -9.8, 0)", "", kOwn,
     "acceleration of every object, such as gravity; a distribution is drawn once for the world",
     "gravity g", "every rotating"},
    {"linear_velocity", kGroup, kVector, kAny, kDrawn, "m/s", "0", "", kOwn,
     "initial velocity of the centre of mass",
     "velocity speed v", "every rotating"},
    {"angular_velocity", kGroup, kVector, kAny, kDrawn, "rad/s", "0", "", kOwn,
     "initial angular velocity",
     "spin rotation omega", "every rotating"},

    // Further parameters of a study: the world,
    {"seed", false, kCount, {.min = 0, .max = kMaxSeed}, kConstant, "", "0xAAAAAAAAAA", "", kOwn,
     "seed of the random streams, one for each distribution",
     "random_seed rng"},
    // In a default, `objects` is the number of objects in all groups, at least 1.
    {"world.side", false, kReal, kPositive, kConstant, "m", "50 * objects", "", kOwn,
     "side of the cube, which is centred on the origin; by default 50 times the number of objects",
     "side cube box width world.size"},
    {"world.walls", false, kWord, kAny, kConstant, "", "all", "all floor none", kOwn,
     "walls of the cube that are present; floor is the one at -y",
     "walls floor ground"},
    {"world.wall_shape", false, kWord, kAny, kConstant, "", "plane", "plane box", kOwn,
     "shape of the walls: infinite planes or boxes"},
    {"timestep", false, kReal, kPositive, kConstant, "s", "1 / 60", "", kOwn,
     "simulated time of one cycle",
     "dt time_step delta_t step frequency hz"},
    {"precision", false, kWord, kAny, kConstant, "", "single", "single double", kOwn,
     "floating-point precision of Bullet",
     "float real"},
    {"detector", false, kWord, kAny, kConstant, "", "dbvt", "", kDetectors,
     "the collision detector",
     "broadphase broad_phase broad algorithm detectors"},
    {"narrow_phase", false, kWord, kAny, kConstant, "", "own", "own", kNarrowPhases,
     "source of the contacts; own is the detector itself if it has a narrow phase, and Bullet otherwise",
     "narrowphase narrow contacts_by"},
    {"pair_order", false, kWord, kAny, kConstant, "", "listed", "listed sorted", kOwn,
     "order in which pairs are processed: as the detector lists them, or sorted by body, so that detectors that list the same pairs move every object identically, to the last bit",
     "order deterministic"},
    {"threads", false, kCount, kCountFromOne, kConstant, "", "1", "", kOwn,
     "threads that the detector may use; detectors without multithreading use one",
     "cores parallel"},
    {"trace", false, kText, kAny, kConstant, "", "none", "none", kOwn,
     "a file of recorded boxes (`cdb trace`), relative to the .cdb file; detectors run on these boxes, without a world",
     "replay recording motion baked", "file"},
    {"contact", false, kWord, kAny, kConstant, "", "bullet", "bullet faithful", kOwn,
     "contact settings: bullet has Bullet's defaults, faithful conserves the energy of elastic bounces"},
    {"solver.iterations", false, kCount, kCountFromOne, kConstant, "", "10", "", kOwn,
     "iterations of the constraint solver over all contacts in a cycle",
     "solver_iterations solver.steps"},
    {"solver.erp", false, kReal, kFraction, kConstant, "", "0.2", "", kOwn,
     "error reduction parameter: fraction of a penetration that is corrected in a cycle"},
    {"solver.warm_start", false, kReal, kFraction, kConstant, "", "0.85", "", kOwn,
     "warm starting: fraction of the last cycle's impulses that the solver starts from; 0 is a cold start"},

    // the objects,
    {"friction", kGroup, kReal, kNotNegative, kDrawn, "", "0.5", "", kOwn,
     "coefficient of sliding friction; a contact uses the product of the coefficients of both bodies"},
    {"rolling_friction", kGroup, kReal, kNotNegative, kDrawn, "m", "0", "", kOwn,
     "resistance to rolling",
     "rolling"},
    {"restitution", kGroup, kReal, kFraction, kDrawn, "", "0", "", kOwn,
     "coefficient of restitution: fraction of the normal velocity that a bounce preserves; a contact uses the product of the coefficients of both bodies",
     "bounce bounciness elasticity"},
    {"linear_damping", kGroup, kReal, kFraction, kDrawn, "", "0", "", kOwn,
     "fraction of the velocity lost per second"},
    {"angular_damping", kGroup, kReal, kFraction, kDrawn, "", "0", "", kOwn,
     "fraction of the angular velocity lost per second"},
    {"margin", kGroup, kReal, kNotNegative, kDrawn, "m", "0.04", "", kOwn,
     "Bullet's collision margin; it does not change the outer extent of the object"},
    {"contact_stiffness", kGroup, kReal, kPositive, kDrawn, "N/m", "rigid", "rigid", kOwn,
     "spring constant of a soft contact"},
    {"contact_damping", kGroup, kReal, kNotNegative, kDrawn, "N s/m", "0.1", "", kOwn,
     "damping coefficient of a soft contact; without effect if the contact is rigid"},
    {"ccd", kGroup, kSwitch, kAny, kDrawn, "", "off", "", kOwn,
     "continuous collision detection, for fast objects"},
    {"orientation", kGroup, kVector, kAny, kDrawn, "rad", "0", "random", kOwn,
     "initial orientation, as axis times angle; random is uniform over all orientations",
     "turn rotation angle"},
    {"links.type", kGroup, kWord, kAny, kConstant, "", "none", "none ball hinge fixed spring", kOwn,
     "link between each object and the next, in order: a ball, hinge (about z) or fixed joint halfway between their centres, or a spring from centre to centre",
     "joint joints constraint constraints links"},
    {"links.stiffness", kGroup, kReal, kPositive, kConstant, "N/m", "1000", "", kOwn,
     "spring constant of each spring; its rest length is its initial length"},
    {"links.damping", kGroup, kReal, kNotNegative, kConstant, "N s/m", "0", "", kOwn,
     "damping coefficient of each spring, along the spring"},
    {"links.anchor", kGroup, kSwitch, kAny, kConstant, "", "on", "", kOwn,
     "links the first object to the world as well, at its initial position",
     "pin"},
    {"links.end_mass", kGroup, kReal, kPositive, kConstant, "kg", "same", "same", kOwn,
     "mass of the last object; same is the mass of the others"},
    {"sleeping", false, kSwitch, kAny, kConstant, "", "on", "", kOwn,
     "objects at rest are put to sleep",
     "sleep deactivation"},

    // and the measurement.
    {"repeats", false, kCount, kCountFromOne, kConstant, "", "1", "", kOwn,
     "timed repeats of each point; with `cdb run --until 1%`, the maximum",
     "repetitions runs reps repeat"},
    {"warmup", false, kCount, kCountFromZero, kConstant, "", "0", "", kOwn,
     "cycles before the first recorded one"},
    {"timeout", false, kReal, kPositive, kConstant, "s", "none", "none", kOwn,
     "wall-clock time after which a run is ended and marked"},
    {"memory", false, kReal, kPositive, kConstant, "B", "none", "none", kOwn,
     "private memory that a run may allocate; a run that needs more is ended and marked",
     "memory_limit max_memory ram", "", true},
    {"record", false, kWords, kAny, kConstant, "", "timing, counts, stability", "", kRecordWords,
     "data that are recorded in each cycle",
     "output store measure metrics"},
    {"expect", false, kWord, kAny, kConstant, "", "auto", "auto anything rest energy", kOwn,
     "expected behaviour of the scene, for its verdict; auto: stacks, pyramids and piles rest, elastic scenes without friction conserve their energy",
     "should verdict"},
    {"omit", false, kWords, kAny, kConstant, "", "auto", "auto none", kComponents,
     "parts of the engine to omit if the scene provably does not need them",
     "prune exclude skip_parts without leave_out"},

    // The comparison with the ground truth.
    {"accuracy.metrics", false, kWords, kAny, kConstant, "", "none", "none", kMetrics,
     "errors to compute, in a second pass that is not timed",
     "errors error accuracy"},
    {"accuracy.interval", false, kReal, kPositive, kConstant, "s", "1 / 15", "", kOwn,
     "simulated time between samples; a whole number of time steps, and the same in every run",
     "accuracy.samples accuracy.every"},
    {"accuracy.closed_form", false, kWord, kAny, kConstant, "", "none", "none", kClosedForms,
     "analytic solution to compare with; with none, errors that need a ground truth are computed from a reference run",
     "accuracy.truth accuracy.analytic"},
    {"accuracy.reference.timestep", false, kReal, kPositive, kConstant, "s", "1 / 3840", "", kOwn,
     "time step of the reference run"},
    {"accuracy.reference.precision", false, kWord, kAny, kConstant, "", "double", "single double", kOwn,
     "precision of the reference run"},
    {"accuracy.reference.detector", false, kWord, kAny, kConstant, "", "dbvt", "", kDetectors,
     "detector of the reference run"},
    {"accuracy.reference.iterations", false, kCount, kCountFromOne, kConstant, "", "100", "", kOwn,
     "solver.iterations of the reference run"},
    {"accuracy.reference.contact", false, kWord, kAny, kConstant, "", "same", "same bullet faithful", kOwn,
     "contact settings of the reference run; same are those of the run"},
});
  // clang-format on
};

inline constexpr const auto& kParameters = ParameterTable::kRows;

}  // namespace cdb::schema
