#include "runtime/report/language_reference.h"

namespace cdb::report {

const std::string_view kLanguageReference = R"reference(THE .cdb LANGUAGE

A file says which scenes to run, which parameters to vary and what to measure. It is a list of
`name value` statements in named blocks; a value is a constant, a distribution (drawn anew for each
object) or a sweep (one run for each value). What is left out has the paper's default, so
`benchmark b { }` is a whole benchmark.

  # Does a long, thin shape slow the broad phase down?
  benchmark aspect "the title of the results" {
    objects {
      quantity  sweep(1000 .. 5000 step 1000)
      type      any(sphere, cuboid, cylinder, cone)
      aspect    1 : 1 : sweep(1 .. 5)
    }
    detector    sweep(simple, sap, dbvt)
  }

LEXICAL RULES
  UTF-8; # begins a comment. A statement ends with its line or with `;`; inside ( ) and in lists a
  line may break after `,`. Numbers: 50  -9.8  1e6  1_000_000  0xAA. Texts: "..." with \" \\ \n \t.
  `benchmark`, `use`, `let`, `cases` and `skip` cannot name anything else.

FILES
  use "other"                 the lets and benchmarks of other.cdb: beside this file, else in the
                              library. Its benchmarks are for `from`; only a file's own are run.
  use detector "mine.so"      the detectors of a shared library of your own, found likewise: their
                              names are words as the catalogue's are (`cdb doc detectors`)
  let name = value            a name for any value
  benchmark name { ... }      one results file
  benchmark name from base { ... }   takes the statements of base and lays its own over them; what
                              is set again keeps its place in the order of axes; a `let` of the
                              same name, and `cases` of the same name, replace those of the base

STATEMENTS
  name value                  a setting; once in a block. `objects.size 5`, or `size 5` in objects { }
  objects { ... }             the objects; several groups have names: objects pebbles { ... }, and
                              then pebbles.size. world { } and solver { } shorten names likewise,
                              and links { } within objects { }: objects.links.type
  cases load { calm { ... } storm { ... } }    an axis of named sets of settings, laid over the rest;
                              unnamed, the axis is `case`. A case may sweep: the axis then holds the
                              values of every case, and cells that no case has are skipped.
  skip when quantity > 3000 and detector == simple     leaves points out; they keep their cell.
                              Names are axes, lets and parameters; and, or, not, ( ), == != < <= > >=
  omit auto                   leaves out what a scene provably does not need; `omit none` times
                              everything; `omit walls, solver` leaves out these: `cdb doc omit`

  accuracy { ... }            what to hold each run against, and by which errors: `cdb doc accuracy`

VALUES
  arithmetic                  + - * / ^ and ( ); exact as long as numbers are whole and fit 64 bits.
                              Vectors add, and stretch by a number.
  names                       a let; another parameter of the same run: world.side 20 * objects.quantity
  (x, y, z)                   a vector; 0 stands for (0, 0, 0)
  1 : y : z                   a ratio
  on off true false           a switch

  uniform(a, b)               each value between alike; for a vector parameter, or with vectors,
                              component by component
  normal(m, s)                mean and standard deviation; normal(m, variance: v), normal(m, sd: s)
  log_uniform(a, b)           the logarithm is uniform; a, b > 0
  any(x, y 3)                 one of them, y three times as often
                              What falls outside a parameter's domain (size <= 0) is drawn again.
                              Each distribution has a stream of its own, seeded by `seed` and the
                              parameter's name, so that one does not move when another is added.

WORDS WITH ARGUMENTS
  A layout, a model or a schedule is a word that may take arguments: `cdb list` shows all of them with
  their units and defaults. Arguments are given by place, then by name; what has a default may be left
  out, and then the word stands alone. One argument by its name needs no brackets.
  location grid               grid(spacing: 3), grid(3) and `grid spacing: 3` are the same
  location at(0, 5, 0)        one object there: quantity 1
  location pair distance: 0.5   two objects, their surfaces so far apart: quantity 2
  type mesh("rock.obj")       a model of your own, by convex pieces; hull("rock.obj") its convex hull.
                              OBJ, PLY, STL or OFF, from the folder of the .cdb file that names it. The
                              plan holds the SHA-256 of its bytes; mesh("rock.obj", sha256: "...") says
                              which it has to be. any(sphere 3, mesh("rock.obj") 1) weighs models too.
  acceleration every(60, uniform((-1, -1, -1), (1, 1, 1)))    drawn anew every 60 cycles
  acceleration rotating((0, -9.8, 0), about: (0, 0, 1), period: 4)    a turn in 4 s
                              Schedules; linear_velocity and angular_velocity take them too, one for
                              each object. None stands in another or in any( ).
  trace "run.trace.h5"        no scene but a recorded one, for its detectors alone: `cdb doc traces`
  Sweeps, lets and arithmetic stand in arguments as anywhere: ring(radius: sweep(1, 2)) is the axis
  location_radius, at(0, sweep(1, 2), 0) the axis location_y.
  A let may be called like such a word: behind a parameter that takes the word, it is the word.

LINKS
  objects { quantity 8; location line; links { type ball } }    a chain; `cdb doc links` has the rest
  Each object is linked to the next of its group, in order, and the first to a point of the world,
  where one more before it would be linked to it; `anchor off` leaves that out. A lone object hangs
  from a point above it. Linked neighbours do not collide. A ball joint turns every way, a hinge about
  z, a fixed one not at all; their pivot is half way between the centres of mass.
  A spring acts between the centres, along a line that turns with the first of the two, and holds the
  other on that line. Its force is neither limited nor softened: it explodes where dt sqrt(k/m) > 2.

SWEEPS
  sweep(v, v, ...)            an axis; wherever a constant may stand, also inside a vector, a ratio or
  sweep(a .. b)               a distribution. a .. b counts by one and hits b
  a .. b step d               a + i*d, never added up
  a .. b count n [log]        n values, both ends included
  let n = sweep(10, 100)      every use of n is the same axis, called n
  sweep(1 .. 5) as z          an axis called z. Else it takes its parameter's name: quantity,
                              aspect_z, pebbles_size, links_type; in `20 * sweep(1, 2)` its values
                              are 20 and 40.
  Two sweeps are two axes, the first written varying slowest; file-level lets come before the rest.
  A value stands on an axis once: `repeats` is what measures a point again.

OBJECTS
  A side is size times its part of aspect: the full extent along x, y and z. An object's own origin
  is its centre of mass; a cone's lies a quarter of its height above the base. Turned objects are
  given by `orientation`, the axis times the angle in rad, or `random`.
  location uniform draws each coordinate between the walls, normal with mean 0 and a third of the
  wall's coordinate as standard deviation; a place that touches a wall or an object is drawn again.
  Objects lie inside the cube also where it has no walls. Where they find no place the run fails and
  says how full the cube is. `overlap on` lets objects begin inside one another, where a layout with
  arguments puts them there: line(gap: -0.5).
)reference";

const std::string_view kOmitReference = R"reference(WHAT A RUN LEAVES OUT

A scene rarely needs all of the engine. What it provably does not need is left out: every object is
in the same place in every cycle, to the last bit, and the run is faster.

  omit auto                   all that the scene does not need; the default
  omit none                   nothing: everything is timed
  omit walls, raycast_tree    just these; a scene that needs one of them is an error
  omit sweep(none, auto)      an axis; `cases { }` are an axis whose values are lists

The numbers of a scenario decide some of it: where the acceleration is 0 nothing applies gravity.
The rest is decided when the objects are drawn and placed, by the worker, before the first cycle:
where each object can get to in the whole run, and whom it may meet on the way.
  `auto` keeps detection wherever `record` has timing, counts or contacts, which ask for it. A list
that names detection leaves it out all the same: it says that nothing is to be detected.
  What meets after all is hard to foretell, so the run watches. Where an object comes near a wall that
it was proven not to reach, or touches two things at once, so that the order of contacts might matter,
`auto` starts the run again with all walls, and a list fails; `needs` in the results says so.
  What changes a measurement is named by `cdb show`, and the results say for each run what became of
each part and why (`omitted`, `needs`). Before a run, `cdb plan FILE` has it as far as the numbers
go, and `cdb plan --why FILE` places the objects and tells all of it.
  Behind `omit`, `sleeping` is the part of that name; elsewhere it is the switch.

)reference";

const std::string_view kVerdictsReference = R"reference(HOW A RUN CAN END

A run that records stability (it does unless `record` says otherwise) gets a verdict, by what is taken
between its cycles, outside every stamp, and the first recorded cycle at which the verdict shows. The
worst that applies is given; in the results `verdict` and `first_bad_cycle`.
  S is the least side of an object (of the smaller one in a contact), g the acceleration. Energy is
kinetic and potential with the integrator's own term, which free flight keeps exactly; its scale is
the kinetic energy at the start and what all objects can gain by falling through the cube. Late is the
last quarter of the run, and there the median counts.
  From `frozen` on bodies did not move as the engine was told: their timings are stored, marked, and
in no summary, and the exit status is 3. What is less bad stands in the figures, and is named.
  `expect` says what a scene ought to do. By itself (auto) a scene of stacks, pyramids or piles, with
nothing moving and gravity down, must rest; one of elastic, rigid objects without friction and damping
keeps its energy; so does every other as long as nothing has touched anything. Where a schedule drives
a scene, energy says nothing.

)reference";

const std::string_view kDetectorsReference = R"reference(DETECTORS

A detector lists the pairs of bodies whose boxes overlap (broad phase) and may find the contacts of
those pairs (narrow phase). What it lacks, Bullet supplies.

  detector sweep(dbvt, auto)  who lists the pairs
  narrow_phase fcl_gjk        who finds their contacts; `own` is the detector itself where it has a
                              narrow phase, else Bullet; `bullet` is always Bullet
  pair_order sorted           pairs are worked on in the order of their bodies: then all detectors
                              that list the same pairs move everything alike, to the bit. (Where
                              bodies sleep, phantoms count too: they decide who sleeps with whom.)
                              Bullet's own four sort anew in each cycle, which is part of their
                              narrow phase; behind the interface it costs next to nothing
  threads 2                   for the detectors that can use them
  record pairs                holds each cycle's list against all pairs there are, in double:
                              missed_pairs, phantom_pairs, duplicate_pairs
  cdb verify FILE             does that for every detector at every point

Bullet's four run as Bullet has them. All others stand behind one interface, library/detectors/
detector.h: boxes in, pairs out. cdb turns the list into changes of Bullet's pair cache, which is
part of the time of the broad phase. A pair that is missed is a collision that does not happen; one
too many (a phantom) costs time in the narrow phase. `null` finds nothing: its time is what calling
a detector costs.

PLUG-INS
  use detector "mine.so"      a shared library with detectors of your own, from the folder of the file
                              that says it, else from the library of scenarios
  cdb run FILE --plugin mine.so    the same on the command line; for check, plan, trace and verify too

The installed header cdb/detector.h is all there is to know, and examples/my_detector is a whole one:
find_package(cdb) has the target cdb::detector. The names in the library are words of `detector` and
`narrow_phase`. A library is loaded by processes of their own alone: one that was built for another
interface, crashes or hangs at loading (10 s) is refused by name. One that throws, crashes, hangs
(`timeout` ends it) or returns what cannot be, a body that is not there or a normal that is not unit,
costs its own runs. The plan names the file and its SHA-256: a library that was built anew is another
run, and a plan refuses one that was changed.

)reference";

const std::string_view kLintsReference = R"reference(NUMBERS THAT BULLET CANNOT FOLLOW

Legal scenes can be beyond what Bullet computes well. `cdb check` works out these numbers for every
run and warns: `will` from the limit on, `may` from a third of it. Each warning is given once for a
benchmark, with the worst run, at what sets it, and says what to write instead. `cdb run` and
`cdb plan` name them in one line. None is an error, and nothing is changed.
  What is drawn counts with its bounds, a normal distribution with three deviations. The limits are
measured: of 1700 random scenes for each precision, 96 in 100 without a warning were stable (`cdb
doc verdicts`), and of those with a `will` 95 in 100 were not. Between a third and the limit either
may be. What no number foretells: box on box has wrong normals now and then, so that heaps of cuboids
can be deep in one another in any scene.
  g is the acceleration, v the speed, that of the fall included, size the least side, iterations
solver.iterations.

)reference";

const std::string_view kAccuracyReference = R"reference(ERRORS BESIDE TIMINGS

  accuracy {
    metrics  position, energy
    reference { timestep 1/3840; precision double }
  }

Each run is timed as without it and then run once more from the same start, without a clock, and
sampled every `interval`. Both passes must end in the same state to the last bit: a run that does not
repeat itself fails. Its samples are held against the truth:

  closed_form flight          what physics says of a simple scene, where it fits; else
  reference { ... }           a run of the same scene from the same start over the same time with these
                              settings. Runs that differ in nothing else share one, so that a sweep of
                              time step x iterations x detector needs one; `cdb plan` counts them.

A reference has a twin, whose objects start 1e-9 of their size away. Where the two part, nobody knows
the truth: `horizon` is the time at which their places are a tenth of a size apart (root of the mean
square over objects; the end where they never are), and errors of position and velocity are taken
up to it. The `floor` of an error is its value between the two: an error below it says nothing. A
closed form has neither: its horizon is the end and its floors are 0.

The errors of a sample become one number as the table says; the start is left out. What cannot be had
has no value, and `message` says why: the reference failed, the state of a run is not a number, the
closed form does not fit. Objects that are fixed count nowhere. A size is an object's largest side.
The energy of a scene, that errors of energy are divided by, is the most kinetic energy of the
reference at a sample and what lifts every object by its own size; a closed form says its own. Energy
is compared as it changes from each run's own start. Heights are along the acceleration at the start.
An exact box is the tightest around the solid, in double, where the detector last looked; Bullet's
are larger by margins and by what an object moves in a step, so that it always has phantom pairs.

An exact overlap is one that a closed form tells, in double, at the same places: of balls, of a ball
and a cuboid, of cuboids, of any of these with a box wall, and of all but compounds with a plane wall,
deeper than a ten thousandth of the smaller object's size. Its depth is the least move that parts the
two. Where another way out is as short within 1 %, its normal counts nowhere. A run without any exact
overlap has no errors of `geometry`.

  /accuracy/NAME (..., rep)             and NAME_floor, horizon, timestep, truth, message
  /accuracy/NAME_series (..., rep, sample)
  /accuracy/reference/...               states and observables of each reference run and its twin

  cdb show FILE --error NAME            each configuration: how fast, how wrong, and whether it is on
                                        the Pareto front. --by AXIS,... makes the rows and takes the
                                        mean over all else; --each AXIS,... a table for each value

)reference";

const std::string_view kResultsReference = R"reference(THE RESULTS FILE

One benchmark, one HDF5 file that is netCDF-4 too: the whole sweep as one tensor with named axes.
For axes quantity and detector:

  quantity(quantity)                      coordinate, one for each axis
  detector(detector)                      text; the attribute `labels` holds the words too
  rep(rep)  phase(phase)  cycle(cycle)    phase: broad narrow detect solve integrate step
  duration(quantity, detector, rep, phase, cycle)    ns; NaN where a cycle did not run
  pairs, contacts, ... (quantity, detector, rep, cycle)
  status(quantity, detector, rep)         0 missing 1 done 2 skipped 3 failed 4 crashed 5 timed_out
  verdict                                 how it ended as physics: `cdb doc verdicts`
  first_bad_cycle                         at which the verdict shows; -1 where none is bad
  n_cycles                                cycles that really ran
  state_hash                              of every body's position, orientation and velocities after
                                          the last cycle; the same plan gives the same, always
  omitted                                 parts of the engine that the run left out: `cdb doc omit`
  needs                                   what became of each part and why, a line each
  run_id, message, host, started, load, peak_rss, place_time, build_time, fill_fraction
  harness                                 ns of a cycle that measuring costs: clock stamps, and calling
                                          a detector that does nothing; in the figures, not subtracted
  /accuracy                               errors, where the scenario asks for them: cdb doc accuracy
  /provenance                             build, machine, plan_text, scenario_text; plugins that the
                                          command line brought; models: how well convex hulls stand
                                          for the meshes of the scene

An axis that is called like a dataset above is stored as NAME_axis: `cases load { }` as load_axis.

`record boxes` adds what the broad phase is given: boxes over box_body (objects, then the walls that
stand), and box_filters, whom each may meet; `cdb trace` makes a file of it.
`record contacts` adds a ragged list: contact_body, contact_point, contact_normal, contact_distance
over `contact`, cell after cell; `contacts` says how many rows each cycle has, contact_first where
those of a run begin.
`record pairs` holds the detector against brute force, in double, on the boxes that it was given in each
cycle: exact_pairs there were, missed_pairs of them it did not list, phantom_pairs it listed do not
overlap, duplicate_pairs it listed again. Contacts are held against closed forms, as by the metric
geometry (cdb doc accuracy): missed_contacts, depth_error, normal_error. -1 and NaN where a cycle has no
such value. Where a run records timing or memory too, all of it comes from a second pass without a clock,
which has to end in the same state. `cdb verify FILE` does this for every detector, and `cdb show` names
those that miss pairs before any figure.
Phases: broad is updating the boxes and finding pairs, narrow is contacts, detect is both and what
lies between, step is the whole cycle. Each is stamped by itself; nothing is subtracted.

)reference";

const std::string_view kTracesReference = R"reference(TRACES

A trace is what the broad phase of a run was given: the box of every body in every cycle. On a trace
all detectors are timed on the same motion, without the physics, and from a file.

  cdb trace FILE [-b NAME] [-o OUT]     runs each point of a benchmark once, as the file says, and
                                        writes NAME.trace.h5, or where there are several points the
                                        folder NAME.traces with a file each. What is there already is
                                        kept; --fresh makes it anew.
  trace "NAME.trace.h5"                 in a benchmark: its detectors are run on that trace. The file
                                        counts from the folder of the .cdb file; sweep("a", "b") is an
                                        axis of several. file("NAME.trace.h5", sha256: "...") says
                                        which it has to be.

  benchmark rivals {
    trace     sweep("dense.traces/dense_n-1000.trace.h5", "dense.traces/dense_n-10000.trace.h5")
    detector  sweep(dbvt, sap32)
    record    timing, counts, memory, pairs
  }

Beside it there are detector, threads, repeats, warmup, cycles, timeout and record (timing, counts,
memory, pairs); all else is of a world and refused by name. cycles is as many as the trace has. The plan
holds the hash of the boxes, so that another trace is another run.
  A cycle of such a run is one call of the detector: broad, detect and step are its time, the other
phases have no value. What a detector does to take the boxes in is in it; laying them out for it is not.
place_time has no value, and build_time is what it takes to make and prepare the detector. `pairs`
counts those that may collide; state_hash is of the last cycle's pairs in order, so that detectors that
list the same pairs have the same.

The file is HDF5, and netCDF-4 too:

  boxes(cycle, body, bound)       m: lower x y z, upper x y z; float32 of a run in single precision. Objects,
                                  then walls; those that the run left out are not there. A plane's are
                                  infinite.
  filters(body, filter)           group, mask, fixed: two may meet where each one's group is in the
                                  other's mask and not both are fixed
  poses(cycle, object, pose)      centre of mass and orientation quaternion after the cycle
  scenario_text, run_text         the scenario, and all that decides the run, as YAML
  attributes                      schema, schema_version, benchmark, point, run_id, state_hash, sha256,
                                  precision, timestep (s), bodies, objects, cycles

  import h5py
  boxes = h5py.File("dense.trace.h5")["boxes"][:]

`cdb list scenarios` has scenes to bake under `detectors`.

)reference";

}  // namespace cdb::report
