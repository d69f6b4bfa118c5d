// Explanations of the kinds in compiler/scenario/diagnostic_kinds.h.
#include "compiler/scenario/diagnostic_kinds.h"
#include "runtime/manual/explanation.h"

namespace cdb::manual {
namespace {

constexpr Explanation kScenarioRows[] = {
    {&scenario::kUnknownName,
     "A name is unknown here: no parameter, block, word, let or benchmark has this name. `cdb doc "
     "parameters` and `cdb list` print all names.",
     "benchmark b { detector spa }\n", "benchmark b { detector sap }\n"},
    {&scenario::kWrongPlace,
     "The name is known, but not allowed here: a property of objects belongs in objects { }, a "
     "property of the run outside of it.",
     "benchmark b { size 5 }\n", "benchmark b { objects { size 5 } }\n"},
    {&scenario::kReservedName,
     "An axis becomes a variable of the results, and cannot have the name of another variable, "
     "such as cycle or phase.",
     "benchmark b { timestep sweep(1 / 60, 1 / 120) as cycle }\n",
     "benchmark b { timestep sweep(1 / 60, 1 / 120) as step_size }\n"},
    {&scenario::kSetTwice,
     "A block can set each parameter only once, and a file can define each name only once.",
     "benchmark b {\n  cycles 5\n  cycles 6\n}\n", "benchmark b {\n  cycles 6\n}\n"},
    {&scenario::kWrongKind,
     "The value is of another kind than the parameter takes: a number instead of a vector, a text "
     "instead of a word, a distribution instead of a constant. `cdb doc NAME` states the kinds "
     "that a parameter takes.",
     "benchmark b { acceleration 5 }\n", "benchmark b { acceleration (0, -5, 0) }\n"},
    {&scenario::kOutOfDomain, "The number is outside the domain of the parameter.",
     "benchmark b { cycles 0 }\n", "benchmark b { cycles 1000 }\n"},
    {&scenario::kNotFinite,
     "The arithmetic has no finite result: a division by zero, or a number too large for a double.",
     "benchmark b { cycles 1 / 0 }\n", "benchmark b { cycles 1000 / 2 }\n"},
    {&scenario::kBadArguments,
     "The arguments do not fit the word: too many, too few, unknown names, or values that exclude "
     "each other. The values of an axis must be distinct.",
     "benchmark b { objects.mass uniform(5) }\n", "benchmark b { objects.mass uniform(5, 10) }\n"},
    {&scenario::kBadRange, "The range is empty or never ends, or its count is not a whole number.",
     "benchmark b { cycles sweep(5 .. 1) }\n", "benchmark b { cycles sweep(5 .. 1 step -1) }\n"},
    {&scenario::kMisplacedSweep,
     "A sweep makes an axis, and is not allowed here: inside another sweep, in a condition, or for "
     "a setting that all runs share.",
     "benchmark b { repeats sweep(1, 3) }\n", "benchmark b { repeats 3 }\n"},
    {&scenario::kMisplacedRange, "A range is a list of values, and belongs in a sweep.",
     "benchmark b { cycles 1 .. 5 }\n", "benchmark b { cycles sweep(1 .. 5) }\n"},
    {&scenario::kAxisTwice,
     "Two sweeps would make axes with the same name. Rename one with `as`, or use one let for "
     "both.",
     "benchmark b { objects.friction normal(sweep(0.5, 0.6), sweep(0.1, 0.2)) }\n",
     "benchmark b { objects.friction normal(sweep(0.5, 0.6), sweep(0.1, 0.2) as deviation) }\n"},
    {&scenario::kCircular,
     "A let, a benchmark or a file refers to itself, directly or through others.",
     "let a = b\nlet b = a\nbenchmark c { cycles 5 }\n",
     "let a = b\nlet b = 5\nbenchmark c { cycles a }\n"},
    {&scenario::kNoSuchFile,
     "The file cannot be read. Its name is relative to the folder of the .cdb file; scenarios are "
     "also found in cdb's library.",
     "use \"no_such_file\"\nbenchmark b { }\n", "benchmark b { }\n"},
    {&scenario::kTooManyRuns,
     "The sweeps make more runs than a plan can hold, or a range has more values than an axis can "
     "hold. Sweep fewer values, or split the benchmark.",
     "benchmark b { seed sweep(1 .. 1e9) }\n", "benchmark b { seed sweep(1 .. 100) }\n"},
    {&scenario::kNoRuns,
     "Nothing is left to run: the file has no benchmark, or every point is skipped.",
     "benchmark b { skip when cycles > 1 }\n",
     "benchmark b { cycles sweep(10, 100); seed sweep(1, 50); skip when cycles < seed }\n"},
    {&scenario::kCapacity, "The detector or the layout cannot handle that many objects.",
     "benchmark b { objects.quantity 20000; detector sap }\n",
     "benchmark b { objects.quantity 20000; detector sap32 }\n"},
    {&scenario::kUnavailable,
     "The scenario names something that is not part of this build, or a file that is not a plug-in "
     "with detectors. `cdb list detectors` names the package of each detector.",
     "use detector \"wrong.cdb\"\nbenchmark b { }\n", "benchmark b { detector dbvt }\n"},
    {&scenario::kBadComparison,
     "The two sides cannot be compared: < compares numbers; == and != compare words.",
     "benchmark b { cycles sweep(1, 2); detector sweep(sap, dbvt); skip when cycles < detector }\n",
     "benchmark b { cycles sweep(1, 2); seed sweep(1, 2); skip when cycles < seed }\n"},
    {&scenario::kContradiction, "Two settings exclude each other.",
     "benchmark b { accuracy { interval 1 } }\n",
     "benchmark b { accuracy { metrics energy; interval 1 } }\n"},
    {&scenario::kNeeded,
     "The scene needs a part that `omit` names. `omit auto` omits every part that it does not "
     "need.",
     "benchmark b { omit gravity }\n", "benchmark b { omit auto }\n"},
    {&scenario::kWrongForm,
     "The closed form does not describe this scene, so the scene cannot be compared with it.",
     "benchmark b { accuracy { metrics position; closed_form flight } }\n",
     "benchmark b {\n  world { walls none; side 1000 }\n  sleeping off\n"
     "  objects { quantity 1; size 10; location at(0, 0, 0); linear_velocity (1, 0, 0) }\n"
     "  acceleration 0\n  accuracy { metrics position; closed_form flight }\n}\n"},
    {&scenario::kCannotPlace,
     "The objects cannot be placed: they lie outside of the cube, overlap, or fill too much of it.",
     "benchmark b { world.side 100; objects { quantity 1000; size 20 } }\n",
     "benchmark b { world.side 1000; objects { quantity 1000; size 20 } }\n"},
    {&scenario::kWrongUnit,
     "The unit of a value has another dimension than the parameter, for example a mass instead of "
     "a length, or numbers with and without a unit are added.",
     "benchmark b { objects.size 5 kg }\n", "benchmark b { objects.size 5 m }\n"},
    {&scenario::kBadTable,
     "A table of measured values has an invalid row: each row is a number, or a number, a comma "
     "and its weight. The numbers have no unit, and are in the unit of the parameter; here "
     "masses.csv has `2.5 kg`.",
     "benchmark b { objects.mass empirical(\"masses.csv\") }\n",
     "benchmark b { objects.mass any(1.5, 2.5) }\n"},
    {&scenario::kRunsWillFail, "Some of the runs cannot be placed; the others can.",
     "benchmark b { world.side 1000; objects { size 200; quantity sweep(1, 2, 500) } }\n",
     "benchmark b { world.side 5000; objects { size 200; quantity sweep(1, 2, 500) } }\n"},
    {&scenario::kUnreachable,
     "No run uses this: every point with this value or case is skipped, every case overrides the "
     "setting, or nothing uses the sweep.",
     "benchmark b {\n  detector sweep(sap, dbvt, simple)\n  skip when detector == simple\n}\n",
     "benchmark b { detector sweep(sap, dbvt) }\n"},
    {&scenario::kEllipsoids,
     "Each side of an object is drawn separately, so that spheres with a drawn size become "
     "ellipsoids. same( ) makes one draw for all three sides.",
     "benchmark b { objects { type sphere; size uniform(10, 50) } }\n",
     "benchmark b { objects { type sphere; size same(uniform(10, 50)) } }\n"},
    {&scenario::kNoEffect,
     "A setting has no effect in any run: a velocity of fixed objects, kinematic objects without "
     "velocity or path, the expected behaviour of a driven scene.",
     "benchmark b { objects { mass fixed; linear_velocity (0, 1, 0) } }\n",
     "benchmark b { objects { mass kinematic; linear_velocity (0, 1, 0) } }\n"},
    {&scenario::kDefaultSize,
     "A group has the default size, and all other groups are much smaller or larger. This may be "
     "an oversight: set the size.",
     "benchmark b {\n  world.side 100\n  objects pebbles { quantity 5; size 1 }\n"
     "  objects plate { quantity 1; type cuboid }\n}\n",
     "benchmark b {\n  world.side 100\n  objects pebbles { quantity 5; size 1 }\n"
     "  objects plate { quantity 1; type cuboid; size 2 }\n}\n"},
};

}  // namespace

std::span<const Explanation> ScenarioExplanations() { return kScenarioRows; }

}  // namespace cdb::manual
