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
     "how many objects",
     "count number n amount objects"},
    {"type", kGroup, kWord, kAny, kDrawn, "", "sphere", "", kObjectTypes,
     "what the objects are",
     "kind shape shapes object types", "mesh hull surface heights"},
    {"aspect", kGroup, kRatio, kPositive, kConstant, "", "1 : 1 : 1", "", kOwn,
     "1 : y : z; a side is size times its part, the full extent along x, y and z; at 1 : 1 : 1 a mesh keeps its own proportions, the longest side is the size"},
    {"location", kGroup, kWord, kAny, kConstant, "", "uniform", "", kLayouts,
     "how the objects are placed; nothing overlaps unless overlap says so",
     "position layout placement distribution", "grid stack pyramid pile ring line at pair poses path"},
    {"overlap", kGroup, kSwitch, kAny, kConstant, "", "off", "", kOwn,
     "objects may begin inside those of any group that has it on too, where a layout with arguments puts them there",
     "overlapping"},
    {"collides_with", kGroup, kWords, kAny, kConstant, "", "all", "all none", kGroups,
     "which groups, and walls, the objects may touch; two groups touch where each one allows the other",
     "collision_group collision_mask collide_bitmask contype conaffinity filter layer", "", true},
    {"size", kGroup, kReal, kPositive, kDrawn, "m", "50", "", kOwn,
     "full extent of an object; a distribution draws each side by itself, and same( ) one value for all",
     "radius diameter length extent scale", "same"},
    {"mass", kGroup, kReal, kPositive, kDrawn, "kg", "1", "fixed kinematic", kOwn,
     "mass of an object, or density( ), from its volume; fixed ones never move, kinematic ones move as their velocities or path say, whatever they meet",
     "weight density", "density"},
    {"acceleration", false, kVector, kAny, kDrawn, "m/s^2", "(0, -9.8, 0)", "", kOwn,
     "acts on every object; a distribution is drawn once for the world",
     "gravity g", "every rotating"},
    {"linear_velocity", kGroup, kVector, kAny, kDrawn, "m/s", "0", "", kOwn,
     "velocity of the centre of mass at the start",
     "velocity speed v", "every rotating"},
    {"angular_velocity", kGroup, kVector, kAny, kDrawn, "rad/s", "0", "", kOwn,
     "spin at the start",
     "spin rotation omega", "every rotating"},

    // Further parameters of a study: the world,
    {"seed", false, kCount, {.min = 0, .max = kMaxSeed}, kConstant, "", "0xAAAAAAAAAA", "", kOwn,
     "every distribution has a random stream of its own, seeded by it",
     "random_seed rng"},
    // In a default, `objects` is the number of objects in all groups, at least 1.
    {"world.side", false, kReal, kPositive, kConstant, "m", "50 * objects", "", kOwn,
     "side of the cube, centred on the origin; 50 times the number of objects where it is left out",
     "side cube box width world.size"},
    {"world.walls", false, kWord, kAny, kConstant, "", "all", "all floor none", kOwn,
     "which walls of the cube stand; floor is the one at -y",
     "walls floor ground"},
    {"world.wall_shape", false, kWord, kAny, kConstant, "", "plane", "plane box", kOwn,
     "infinite planes, or boxes"},
    {"timestep", false, kReal, kPositive, kConstant, "s", "1 / 60", "", kOwn,
     "simulated time of one cycle",
     "dt time_step delta_t step frequency hz"},
    {"precision", false, kWord, kAny, kConstant, "", "single", "single double", kOwn,
     "of Bullet's numbers",
     "float real"},
    {"detector", false, kWord, kAny, kConstant, "", "dbvt", "", kDetectors,
     "the collision detector",
     "broadphase broad_phase broad algorithm detectors"},
    {"narrow_phase", false, kWord, kAny, kConstant, "", "own", "own", kNarrowPhases,
     "who finds the contacts of the detector's pairs; own is the detector itself where it has a narrow phase, else Bullet",
     "narrowphase narrow contacts_by"},
    {"pair_order", false, kWord, kAny, kConstant, "", "listed", "listed sorted", kOwn,
     "in which order pairs are worked on: as the detector lists them, or sorted by body, so that all who list the same pairs move alike to the bit",
     "order deterministic"},
    {"threads", false, kCount, kCountFromOne, kConstant, "", "1", "", kOwn,
     "threads that the detector may work on; those without threads work on one",
     "cores parallel"},
    {"trace", false, kText, kAny, kConstant, "", "none", "none", kOwn,
     "the file of a recorded run (`cdb trace`), from the folder of the .cdb file: detectors are run on its boxes, without a world",
     "replay recording motion baked", "file"},
    {"contact", false, kWord, kAny, kConstant, "", "bullet", "bullet faithful", kOwn,
     "Bullet's own contact settings, or those under which bounces keep their energy"},
    {"solver.iterations", false, kCount, kCountFromOne, kConstant, "", "10", "", kOwn,
     "sweeps of the constraint solver over all contacts in a cycle",
     "solver_iterations solver.steps"},
    {"solver.erp", false, kReal, kFraction, kConstant, "", "0.2", "", kOwn,
     "part of a penetration that is mended in a cycle"},
    {"solver.warm_start", false, kReal, kFraction, kConstant, "", "0.85", "", kOwn,
     "part of the last cycle's impulses that the solver starts from; 0 is a cold start"},

    // the objects,
    {"friction", kGroup, kReal, kNotNegative, kDrawn, "", "0.5", "", kOwn,
     "coefficient of sliding friction; a contact takes the product of both"},
    {"rolling_friction", kGroup, kReal, kNotNegative, kDrawn, "m", "0", "", kOwn,
     "resistance to rolling",
     "rolling"},
    {"restitution", kGroup, kReal, kFraction, kDrawn, "", "0", "", kOwn,
     "part of the normal velocity that a bounce keeps; a contact takes the product of both",
     "bounce bounciness elasticity"},
    {"linear_damping", kGroup, kReal, kFraction, kDrawn, "", "0", "", kOwn,
     "part of the velocity lost in a second"},
    {"angular_damping", kGroup, kReal, kFraction, kDrawn, "", "0", "", kOwn,
     "part of the spin lost in a second"},
    {"margin", kGroup, kReal, kNotNegative, kDrawn, "m", "0.04", "", kOwn,
     "Bullet's collision margin; the outer extent of the object stays what size says"},
    {"contact_stiffness", kGroup, kReal, kPositive, kDrawn, "N/m", "rigid", "rigid", kOwn,
     "spring constant of a soft contact"},
    {"contact_damping", kGroup, kReal, kNotNegative, kDrawn, "N s/m", "0.1", "", kOwn,
     "damper of a soft contact; without effect where the contact is rigid"},
    {"ccd", kGroup, kSwitch, kAny, kDrawn, "", "off", "", kOwn,
     "continuous collision detection, for fast objects"},
    {"orientation", kGroup, kVector, kAny, kDrawn, "rad", "0", "random", kOwn,
     "turn at the start as axis times angle; random is uniform over all turns",
     "turn rotation angle"},
    {"links.type", kGroup, kWord, kAny, kConstant, "", "none", "none ball hinge fixed spring", kOwn,
     "what holds each object to the next, in order: a ball, hinge (about z) or fixed joint half way between their centres, or a spring from centre to centre",
     "joint joints constraint constraints links"},
    {"links.stiffness", kGroup, kReal, kPositive, kConstant, "N/m", "1000", "", kOwn,
     "of each spring; its length at the start is its length at rest"},
    {"links.damping", kGroup, kReal, kNotNegative, kConstant, "N s/m", "0", "", kOwn,
     "of each spring, along it"},
    {"links.anchor", kGroup, kSwitch, kAny, kConstant, "", "on", "", kOwn,
     "the first object is linked to the world too, where it starts",
     "pin"},
    {"links.end_mass", kGroup, kReal, kPositive, kConstant, "kg", "same", "same", kOwn,
     "mass of the last object; same is that of the others"},
    {"sleeping", false, kSwitch, kAny, kConstant, "", "on", "", kOwn,
     "objects at rest are put to sleep",
     "sleep deactivation"},

    // and the measurement.
    {"repeats", false, kCount, kCountFromOne, kConstant, "", "1", "", kOwn,
     "timed repeats of each point; with `cdb run --until 1%`, the most of them",
     "repetitions runs reps repeat"},
    {"warmup", false, kCount, kCountFromZero, kConstant, "", "0", "", kOwn,
     "cycles before the first that is recorded"},
    {"timeout", false, kReal, kPositive, kConstant, "s", "none", "none", kOwn,
     "wall time after which a run is ended and marked"},
    {"memory", false, kReal, kPositive, kConstant, "B", "none", "none", kOwn,
     "private memory that a run may allocate; one that needs more is ended and marked",
     "memory_limit max_memory ram", "", true},
    {"record", false, kWords, kAny, kConstant, "", "timing, counts, stability",
     "timing counts energy stability contacts poses memory pairs boxes", kOwn,
     "what is stored of each cycle",
     "output store measure metrics"},
    {"expect", false, kWord, kAny, kConstant, "", "auto", "auto anything rest energy", kOwn,
     "what the scene ought to do, for its verdict; auto: stacks, pyramids and piles rest, elastic scenes without friction keep their energy",
     "should verdict"},
    {"omit", false, kWords, kAny, kConstant, "", "auto", "auto none", kComponents,
     "which parts of the engine to leave out that the scene provably does not need",
     "prune exclude skip_parts without leave_out"},

    // The comparison with the ground truth.
    {"accuracy.metrics", false, kWords, kAny, kConstant, "", "none", "none", kMetrics,
     "errors to collect, in a pass of its own beside the timed one",
     "errors error accuracy"},
    {"accuracy.interval", false, kReal, kPositive, kConstant, "s", "1 / 15", "", kOwn,
     "simulated time from one sample to the next; a whole number of time steps, and the same in every run",
     "accuracy.samples accuracy.every"},
    {"accuracy.closed_form", false, kWord, kAny, kConstant, "", "none", "none", kClosedForms,
     "what is true by physics alone; none makes a reference run where errors need one",
     "accuracy.truth accuracy.analytic"},
    {"accuracy.reference.timestep", false, kReal, kPositive, kConstant, "s", "1 / 3840", "", kOwn,
     "time step of the reference run"},
    {"accuracy.reference.precision", false, kWord, kAny, kConstant, "", "double", "single double", kOwn,
     "of the reference run"},
    {"accuracy.reference.detector", false, kWord, kAny, kConstant, "", "dbvt", "", kDetectors,
     "of the reference run"},
    {"accuracy.reference.iterations", false, kCount, kCountFromOne, kConstant, "", "100", "", kOwn,
     "solver.iterations of the reference run"},
    {"accuracy.reference.contact", false, kWord, kAny, kConstant, "", "same", "same bullet faithful", kOwn,
     "of the reference run; same is the run's own"},
});
  // clang-format on
};

inline constexpr const auto& kParameters = ParameterTable::kRows;

}  // namespace cdb::schema
