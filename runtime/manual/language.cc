#include "runtime/manual/language.h"

namespace cdb::manual {

const std::string_view kLanguageReference = R"reference(THE .cdb LANGUAGE

A file states which scenes to run, which parameters to vary and what to measure. It is a list of
`name value` statements in named blocks. A value is a constant, a distribution (drawn for each
object) or a sweep (one run for each value). Parameters that are not set have the defaults of the
paper, so `benchmark b { }` is a complete benchmark.

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
  Files are UTF-8. # begins a comment. A statement ends at the end of its line or at `;`; inside ( )
  and in lists, a line may break after `,`. Numbers: 50  -9.8  1e6  1_000_000  0xAA. Texts: "..."
  with the escapes \" \\ \n \t. `benchmark`, `use`, `let`, `cases` and `skip` are reserved words.

FILES
  use "other"                 imports the lets and benchmarks of other.cdb, from the folder of this
                              file or else from the library. Imported benchmarks can be extended by
                              `from`; only a file's own benchmarks are run.
  use detector "mine.so"      loads the detectors of a shared library, found in the same way. Their
                              names can then be used like those of the catalogue (`cdb doc
                              detectors`).
  let name = value            names a value
  benchmark name { ... }      defines a benchmark, which yields one results file
  benchmark name from base { ... }   extends a benchmark: takes the statements of base and overrides
                              them. A setting that is overridden keeps its place in the order of
                              axes; a `let` or `cases` replaces the one of the same name in base.

STATEMENTS
  name value                  sets a parameter, once in a block: `objects.size 5`, or `size 5` in
                              objects { }
  objects { ... }             a group of objects. If there are several groups, they have names:
                              objects pebbles { ... }, whose size is then pebbles.size. The blocks
                              world { } and solver { } shorten names in the same way, and so does
                              links { } within objects { }: objects.links.type
  cases load { calm { ... } storm { ... } }    an axis of named sets of settings, which override the
                              other settings. Without a name, the axis is called `case`. If a case
                              contains a sweep, the axis holds the values of every case, and cells
                              that belong to no case are skipped. An axis cannot have the name of
                              a variable of the results: see `cdb doc results`.
  skip when quantity > 3000 and detector == simple     skips points, which remain as cells of the
                              results. Names are axes, lets and parameters; operators are
                              and, or, not, ( ), == != < <= > >=, in and not in:
                              skip when detector in (simple, sap)
  only when quantity < 100    skips all other points. With several statements, a point is skipped
                              if any of them skips it.
  omit auto                   omits the parts of the engine that a scene provably does not need;
                              `omit none` times everything; `omit walls, solver` omits these parts.
                              See `cdb doc omit`.
  accuracy { ... }            the errors to compute, and the reference: see `cdb doc accuracy`

VALUES
  arithmetic                  + - * / ^ and ( ). Exact as long as numbers are whole and fit into 64
                              bits. Vectors can be added, and multiplied by a number.
  round(x) floor ceil abs min max sqrt sin cos exp log, and pi    functions of numbers; round( )
                              gives a whole number, and rounds halves away from zero:
                              quantity round(10 ^ sweep(1 .. 3)). Angles are in rad. A let may have
                              the name of a function.
  names                       a let, or another parameter of the same run:
                              world.side 20 * objects.quantity. For parameters that are drawn for
                              each object, see below: mass 2 * size ^ 3
  (x, y, z)                   a vector; 0 is short for (0, 0, 0)
  1 : y : z                   a ratio
  on off true false           a switch
  10 ms   5 cm   90 deg/s     a number with a unit, converted to SI exactly: 10 ms is 0.01. The unit
                              belongs to the product before it: 1/60 s, (0, -981, 0) cm/s^2, and
                              uniform(1, 5) cm. A name needs brackets: (n) ms. Units are km m cm mm
                              um, t kg g mg, h min s ms us ns, rad deg rpm, Hz kHz, N kN, Pa kPa MPa,
                              B kB MB GB TB KiB MiB GiB TiB, with powers and quotients: kg/m^3. The
                              dimension has to be that of the parameter. A number without a unit is
                              in the SI unit given by `cdb doc parameters`. That lengths are in
                              metres is a convention, as in MJCF and Scenic, whose only unit is the
                              degree.

  uniform(a, b)               uniform between a and b. Vectors are drawn component by component.
  normal(m, s)                mean and standard deviation; also normal(m, variance: v) and
                              normal(m, sd: s)
  log_uniform(a, b)           uniform in the logarithm; a, b > 0
  any(x, y 3)                 one of the values; here y is three times as likely as x
  lognormal(mu, sigma)        mean and standard deviation of the natural logarithm; also
                              lognormal(median: 5 cm, sigma: 0.4)
  exponential(mean)   gamma(shape, scale)   weibull(shape, scale)
  empirical("sizes.csv")      one of the measured values of a file. Each line holds a value, or a
                              value, a comma and its weight; a heading is optional. The plan stores
                              the values.
  normal(5, 1) in 2 .. 8      limits: values outside are drawn again; not for any( )
                              (Scenic has Normal, TruncatedNormal, Range and Discrete; JUBE and MJCF
                              have no distributions.)
                              A value outside the parameter's domain (size <= 0) is drawn again.
                              Each distribution has a separate random stream, seeded by `seed` and
                              the name of the parameter, so that adding one does not affect others.

WORDS WITH ARGUMENTS
  Layouts, models and schedules are words that may take arguments; `cdb list` shows them with units
  and defaults. Arguments are given by position, then by name. Arguments with a default are optional;
  without any arguments, the word stands alone. A single named argument needs no parentheses.
  location grid               grid(spacing: 3), grid(3) and `grid spacing: 3` are equivalent
  location at(0, 5, 0)        one object at this point
  location at((0, 5, 0), (1, 5, 0))    one object at each of these points, in order. Without a
                              quantity, there are as many objects as points.
  location poses("start.csv") positions from a CSV file, whose first line names its columns: x,y,z
                              (m), and optionally qw,qx,qy,qz (unit quaternion), vx,vy,vz (m/s) and
                              wx,wy,wz (rad/s). An HDF5 file has them as the datasets position,
                              orientation, linear_velocity and angular_velocity, with a row for each
                              object. The plan stores a SHA-256, as for a mesh.
  location poses("run.h5", run: "detector=dbvt", cycle: 99, group: "pebbles")    the poses that a
                              run with `record poses` had after a cycle, by default the last.
                              Velocities are not recorded. Contacts in Bullet penetrate a little:
                              `overlap on` permits these overlaps, and objects that reach into a
                              wall.
  location pile               dropped from above, and at rest before the first cycle. All runs with
                              the same pile settle it once, also if they run side by side. It is
                              kept in ~/.cache/cdb, and depends on neither detector, precision,
                              solver nor initial velocities. A timeout includes the time of
                              settling; `cdb plan --estimate` predicts it.
  location path("lift.csv")   one kinematic object, moved along a path: a CSV file with the columns
                              t,x,y,z (s, m) and optionally qw,qx,qy,qz. Between the lines,
                              positions are interpolated linearly and orientations spherically.
                              Before the first line and after the last, the object does not move;
                              path("lift.csv", then: repeat) starts over, and needs equal first and
                              last poses. The plan stores a SHA-256.
  location pair distance: 0.5   two objects, with this distance between their surfaces; needs
                              quantity 2
  type mesh("rock.obj")       your own model, decomposed into convex hulls; hull("rock.obj") is its
                              convex hull. The file is OBJ, PLY, STL or OFF; its path is relative to
                              the .cdb file. The plan stores the SHA-256 of the file, and
                              mesh("rock.obj", sha256: "...") refuses a file with another hash.
                              any(sphere 3, mesh("rock.obj") 1) gives weights to models too.
  type surface("hill.obj")    the triangles of your own mesh, open or closed, unchanged, for ground
                              and other fixed objects: a btBvhTriangleMeshShape. It has no inside,
                              so it needs `mass fixed`, and objects may begin on either side of it;
                              an object that crosses it has tunnelled. Its position is the middle of
                              its box; at aspect 1 : 1 : 1 its longest side is the size. Its contacts
                              are always computed by Bullet, whatever the narrow phase. (MJCF and
                              URDF take the convex hull of a mesh; SDF takes the triangles, also for
                              moving bodies. The words mesh, hull and surface tell them apart.)
  type heights("hill.csv")    a height field: a btHeightfieldTerrainShape, which is fixed and placed
                              like a surface. Each line of the file is a row of heights along x,
                              separated by commas; the lines follow each other along z.
                              heights("hill.csv", cell: 0.5) has two heights per unit of height; the
                              default is one. (MJCF's hfield and SDF's heightmap take images, and
                              four sizes.)
  acceleration every(60, uniform((-1, -1, -1), (1, 1, 1)))    drawn again every 60 cycles
  acceleration rotating((0, -9.8, 0), about: (0, 0, 1), period: 4)    one turn in 4 s
                              These are schedules. linear_velocity and angular_velocity take them
                              too, one for each object. Schedules cannot be nested, or be used in
                              any( ).
  size same(uniform(1, 5))    one draw for all sides of an object, so that spheres stay spheres.
                              Without same( ), a distribution draws each side, as in the paper. (In
                              MJCF and Scenic, too, a size is one number or one for each side.)
  mass density(2.7 g/cm^3)    computes the mass of each object from its volume; density( ) takes
                              distributions. It replaces the mass; MJCF has two attributes, one of
                              which overrides the other.
  mass 2.7 g/cm^3 * size ^ 3  refers by name to another number of the same object: with
                              size same(uniform(1, 5)), each object gets the mass of its own size.
                              Any number of an object may be such a formula, with the operators and
                              functions above; it does not change other draws. It can refer to
                              settings of its own group that have a single number for each object:
                              not to `size uniform(1, 5)`, which draws each side. A result outside
                              the domain of the setting is an error, as it cannot be drawn again;
                              max( ) and min( ) set limits. In a formula with units, a name has the
                              unit of its setting; without units, all numbers are SI. (MJCF draws
                              nothing, so that a script has to write each object; JUBE's python mode
                              computes a parameter for a run and not for an object; Scenic has
                              self.width in Python expressions, and sorts the specifiers by their
                              dependencies. Here a name is enough.)
  trace "run.trace.h5"        runs the detectors on recorded boxes instead of a scene: see `cdb doc
                              traces`
  Arguments may contain sweeps, lets and arithmetic: ring(radius: sweep(1, 2)) makes the axis
  location_radius, and at(0, sweep(1, 2), 0) the axis location_y.
  A let may have the same name as such a word. After a parameter that takes the word, the name means
  the word.

LINKS
  objects { quantity 8; location line; links { type ball } }    a chain; see `cdb doc links`
  Each object is linked to the next one of its group, in order. The first object is linked to the
  world, at the point where it would be linked to a preceding object; `anchor off` omits this link.
  A single object hangs from a point above it. Linked neighbours do not collide. A ball joint turns
  about any axis, a hinge about z, and a fixed joint not at all; the pivot is halfway between the
  centres of mass.
  A spring acts between the centres of mass, along a line that turns with the first object, and keeps
  the second object on this line. Its force is neither limited nor softened: the simulation explodes
  if dt sqrt(k/m) > 2.

SWEEPS
  sweep(v, v, ...)            an axis. A sweep may replace any constant, also inside a vector, a
                              ratio or a distribution.
  sweep(a .. b)               counts from a to b by one, b included
  a .. b step d               computed as a + i*d, without accumulating rounding errors
  a .. b count n [log]        n values, both ends included. Where a parameter is a count, those of a
                              logarithmic range are rounded, and equal ones become one.
  let n = sweep(10, 100)      every use of n is the same axis, called n
  sweep(1 .. 5) as z          an axis called z. Without `as`, the axis is named after its parameter:
                              quantity, aspect_z, pebbles_size, links_type. The values of
                              `20 * sweep(1, 2)` are 20 and 40.
  let n, s = zip(sweep(10, 20), sweep(50, 70))    one axis, along which n and s change together. It is
                              called n, or as `zip(...) as load` says, and has the values of the
                              first sweep; if these are not distinct, labels of all.
  Two sweeps make two axes. The first one in the file varies slowest; axes of the file's lets precede
  all others. The values of an axis must be distinct; use `repeats` to measure a point several times.

OBJECTS
  A side is size times its part of aspect: the full extent along x, y or z. The origin of an object
  is its centre of mass; that of a cone is a quarter of its height above the base. `orientation` is
  an axis times an angle in rad, or `random`.
  `location uniform` draws each coordinate uniformly between the walls. `location normal` has mean 0
  and a standard deviation of a third of the wall's coordinate. A position that touches a wall or an
  object is drawn again; a layout with arguments may let surfaces touch. Objects lie inside the cube
  even if it has no walls. `cdb check` reports objects that lie outside the cube, overlap or do not
  fit: as an error if no run can be placed, and as a warning otherwise. If there is no free position,
  the run fails, and its message states the packing fraction. `overlap on` permits initial overlaps,
  if a layout with arguments yields them: line(gap: -0.5).
  `mass fixed` objects never move. `mass kinematic` objects move whatever they meet: with the constant
  linear_velocity and angular_velocity of their group, as a conveyor or a stirrer does, or along a
  path. Nothing pushes them, they push all other objects, and objects that touch them do not sleep. At
  the start of each cycle, they are at the position that their motion has at that time, and contacts
  use the velocity that takes them to the position of the next cycle: the motion is the same for every
  time step. They may leave the cube and pass through walls and fixed objects. As they do work, energy
  is not checked (`cdb doc verdicts`), and `omit` keeps every part that they could affect. (MJCF needs
  a program that sets the poses of mocap bodies, SDF a plug-in or an actor beside its models; here it
  is a word of `mass`.)
  `collides_with` names the groups, and `walls`, that the objects of a group may touch: `collides_with
  walls, pebbles`, `all` (the default) or `none`. Two groups touch only if each one allows the other.
  Objects that may not touch form no pairs and no contacts, under any detector, and may overlap
  initially.
)reference";

const std::string_view kOmitReference = R"reference(WHAT A RUN OMITS

Few scenes need every part of the engine. cdb omits the parts that a scene provably does not need:
every object has the same state in every cycle, to the last bit, and the run is faster.

  omit auto                   omits every part that the scene does not need; the default
  omit none                   omits nothing: everything is timed
  omit walls, raycast_tree    omits exactly these parts; it is an error if a scene needs one of them
  omit auto, wall_pairs       as auto, and also omits pairs with planes whose half-space the box of
                              the object does not reach
  omit sweep(none, auto)      an axis; `cases { }` can make an axis whose values are lists

Some decisions follow from the settings alone: if the acceleration is 0, gravity need not be
applied. The worker makes the others before the first cycle, once the objects have been drawn and
placed: from the region in which each object can be during the run, and the objects that it may meet.
  `auto` keeps detection if `record` has timing, counts or contacts, as these require it. A list
that names detection omits it even then: it states that nothing is to be detected.
  Contacts are hard to predict, so the run is monitored. If an object approaches a wall that it was
proven not to reach, or touches two things at once, so that the order of contacts might matter, the
run is restarted with all walls under `auto`, and fails under a list; /run/needs in the results
says so.
  Runs that differ only in detector, narrow phase, pair order, threads, seed or repeat are compared,
so they have the same parts wherever that affects a measurement: if one of them needs a part, those
that were measured without it are measured again. (With `--shard`, this applies to the runs of one
shard; in plans of more than 100,000 runs, to those of one part, about 10,000 runs.)
  `cdb show` names every omission that affects a measurement. The results state the decision about
each part of each run, and its reason (/run/omitted, /run/needs). `cdb plan FILE` shows the decisions
that follow from the settings, before any run; `cdb plan --why FILE` places the objects and explains
every decision.
  Bullet pairs every object with every plane, as its planes have infinite boxes. `wall_pairs` gives
a plane the box of its half-space, so that only objects that reach it are in a pair with it. This
needs `pair_order sorted`, and objects of one convex piece without ccd; otherwise it is an error.
Under these conditions, detectors other than Bullet's four never list the other pairs, whether `omit`
names wall_pairs or not. Most pairs of a gas in a cube are pairs with planes, so wall_pairs changes the
work on which a detector is measured; `auto` therefore does not include it.
  After `omit`, `sleeping` is the part of that name; elsewhere it is the switch.

)reference";

const std::string_view kNoiseReference = R"reference(WHETHER A RUN HAD THE MACHINE TO ITSELF

Every run measures the disturbances by the machine during its recorded cycles. The group /run of the
results has `cycles_time`, `cpu_time`, `preemptions`, `page_faults`, `steal`, `other_time` and
`processors`, and the `load_average` at its start. From these, a run is judged quiet or noisy (`noise`,
with the reason in `noise_cause`). It is noisy if
  - more than 2 % of the time was not spent on a processor (runs with one thread),
  - other virtual machines stole more than 1 % of the time,
  - other programs used more than a tenth of a processor meanwhile (and more than 30 ms), on any
    processor: they share caches, memory and frequency with the run,
  - the load average of the minute before the run was above the number of processors of the machine,
    or
  - a few long pauses make the mean step more than twice the median, while nine in ten steps are
    within 1.5 medians.
`cdb show` begins with the number of noisy runs and the causes. Their times stay in the figures:
repeats compensate for pauses, as the time of each cycle is its median over the repeats.
  `cdb run FILE --retry-noisy 3` measures a noisy run again at once, up to three times, and keeps the
quietest measurement. If none is quiet, it keeps the one that lost the least time to other programs.
`attempts` is the number of times that a run was measured. `cdb run FILE --retry noisy` repeats the
noisy runs of finished results and replaces them; all other runs are kept.
  `cdb run FILE --until 1%` chooses the number of repeats. With `repeats 50` in the scenario, it runs 5
repeats of every point, and then as many more as the widest interval requires, until the 95 % interval
of every mean step is within 1 % of it or all 50 are done. Every point gets the same number of repeats.
Runs that were not needed have the status `missing`. For more repeats, run it again with a smaller
percentage; for all of them, without --until. Stopping when the intervals are narrow makes them
slightly too narrow.

A run with one thread stays on one of the processors that `cdb` may use (taskset, cpuset); with
--jobs, each of the parallel runs has a separate processor. Several `cdb run` on one machine choose
different processors. If none is free, and for detectors with several threads, the system chooses.
Parallel runs still disturb one another through caches, memory and frequency: `--jobs` is refused for
a plan that records timing, unless --shared-timings says that its times do not matter.
)reference";

const std::string_view kVerdictsReference = R"reference(HOW A RUN CAN END

A run that records stability (the default of `record` includes it) gets a verdict, from data sampled
between cycles, outside the timed phases, together with the first recorded cycle at which the verdict
applies. If several apply, the worst counts. In the results: `verdict` and `first_bad_cycle`.
  S is the least side of an object (of the smaller one in a contact), g the acceleration. Energy is
kinetic and potential energy with the integrator's own term, which free flight conserves exactly. Its
scale is the initial kinetic energy plus what all objects can gain by falling through the cube.
`Late` refers to the median over the last quarter of the run.
  From `frozen` upwards, bodies did not move as the engine was told. The timings of such runs are
stored; `cdb show` marks them, prints them in separate rows and never ranks them with sound ones; the
exit status is 3. Runs with milder verdicts are named, and are part of the summaries.
  An object is frozen (series frozen) if rounding takes or adds a tenth of its motion: the distance
that it moved since it was last pushed lies outside 0.9 .. 1.1 of |v| dt, counted from a hundredth of
its least side on, or in flight it gains less than 0.9 g dt. The series lost_way has the largest
distance lost, in least sides. If fewer than 1 % of the objects are frozen, the work of collision
detection is not affected, and the verdict is `clamped`. The series displaced counts the objects that
moved by > 0.25 S; if they must rest and are fewer than 1 %, the verdict is `drifting`.
  `expect` states the expected behaviour of a scene. By default (auto), a scene of stacks, pyramids or
piles must rest if nothing moves initially and gravity points down; a scene of elastic, rigid objects
without friction and damping must conserve its energy; and so must any other scene until the first
contact. If a schedule or a kinematic object drives the scene, energy is not checked.
  Energy is lost (series lost_energy) if neither the work of friction nor that of inelastic bounces nor
the sleep of a sliding object accounts for the loss, relative to the largest kinetic energy so far. In
a free spin, a loss of 0.03 is enough. This is not checked if anything else can dissipate energy:
damping, rolling friction, soft contacts, or `expect anything`. Default contacts lose energy in elastic
bounces; `contact faithful` does not.
  An object has passed through another (series passed) if its centre of mass went through it, or if,
within one cycle, a ball about the centre with half the inner radius did; through a surface, if its
centre crossed it. A contact is pressed in (series pressed) if it was shallow for three cycles and is
then deep for six, or if an impact leaves it deep for half a second. An object sleeps unheld (series
unheld) if it sleeps in the air, or if it moved before and no contact forces within friction can hold
it in equilibrium, with neither a net force nor a net torque.

)reference";

const std::string_view kDetectorsReference = R"reference(DETECTORS

A detector lists the pairs of bodies whose boxes overlap (broad phase), and may find the contacts of
those pairs (narrow phase). Bullet provides any phase the detector does not.

  detector sweep(dbvt, auto)  the detector that lists the pairs
  narrow_phase fcl_gjk        the source of their contacts. `own` is the detector itself if it has a
                              narrow phase, and Bullet otherwise; `bullet` is always Bullet.
  pair_order sorted           processes pairs in the order of their bodies, so that all detectors
                              that list the same pairs move every object identically, to the last
                              bit. (If bodies can sleep, false positive pairs matter too: they decide
                              which bodies sleep together.) Bullet's own four detectors sort the
                              pairs in each cycle, as part of their narrow phase; for all others,
                              sorting costs next to nothing.
  threads 2                   threads, for detectors that can use them
  record pairs                compares the pairs of each cycle with exact pairs, computed by brute
                              force in double precision: missed_pairs, phantom_pairs,
                              duplicate_pairs
  cdb verify FILE             does this for every detector at every point

Bullet's four detectors run unmodified. All others implement one interface, library/detectors/
detector.h, which takes boxes and returns pairs. cdb computes the boxes of all bodies in one pass and
translates the list of pairs into changes of Bullet's pair cache; both count as time of the broad
phase. A missed pair is a collision that does not happen; a false positive pair (phantom_pairs) costs
time in the narrow phase. `null` finds nothing: its time is the cost of calling a detector.
  In Bullet, the box of a plane is infinite, so that every object is in a pair with every plane. With
`pair_order sorted`, the detectors of the interface get the box of the half-space instead, widened by
the distance up to which Bullet keeps contacts, and list the objects that reach it; every object moves
as before, to the last bit. With `pair_order listed`, with ccd, or with objects of several convex
pieces, the boxes of planes remain infinite, because the motion depends on all pairs there.

PLUG-INS
  use detector "mine.so"      a shared library with your own detectors, from the folder of the file
                              that names it, or else from the library of scenarios
  cdb run FILE --plugin mine.so    the same on the command line; also for check, plan, trace and
                              verify

A plug-in needs only the installed header cdb/detector.h; examples/my_detector is a complete one. The
CMake package `cdb` has the target cdb::detector. The names of a plug-in's detectors become words of
`detector` and `narrow_phase`. Before the run, `cdb` reads these names from the file without running
any of its code, so that `check` and `plan` are safe with a library of unknown origin; `run`, `trace`
and `verify` run its code, confined (`cdb doc limits`). A plug-in that was built for another version of
the interface is refused by name. A plug-in is loaded only by the processes of its runs: if it crashes
or hangs on loading, or a detector throws, crashes, hangs (`timeout` ends it) or returns an invalid
result, such as an unknown body or a normal that is not a unit vector, only its own runs fail. The plan
stores the file name and its SHA-256: rebuilding the library makes new runs, and a plan refuses a
library that has changed.

)reference";

const std::string_view kLintsReference = R"reference(SCENES THAT BULLET CANNOT SIMULATE ACCURATELY

A valid scene can be beyond what Bullet computes well. `cdb check` computes these numbers for every
run and warns: `will` from the limit up, `may` from a third of it. Each warning is given once for a
benchmark, for the worst run, at the setting that causes it, and suggests a remedy. `cdb run` and
`cdb plan` name the warnings in one line. None is an error, and no setting is changed.
  Distributions are judged by their bounds, a normal distribution by three standard deviations. The
limits are measured: of 1700 random scenes for each precision, 96 in 100 without a warning were
stable (`cdb doc verdicts`), and 95 in 100 with a `will` were not. Between a third of the limit and the
limit, both occur. One failure is not predicted: contacts between boxes occasionally have wrong
normals, so that heaps of cuboids can interpenetrate deeply in any scene.
  g is the acceleration, v the speed including that of the fall, size the least side, and iterations is
solver.iterations.

)reference";

const std::string_view kAccuracyReference = R"reference(ERRORS BESIDE TIMINGS

  accuracy {
    metrics  position, energy
    reference { timestep 1/3840; precision double }
  }

Each run is timed as usual and then repeated from the same start, without a clock, with a sample
every `interval`. Both passes must end in the same state, to the last bit; a run that is not
repeatable fails. The samples are compared with the ground truth:

  closed_form flight          the analytic solution of a simple scene; `cdb check` refuses a scene
                              that does not meet its conditions, and names the unmet condition; or
  reference { ... }           a run of the same scene, from the same start over the same time, with
                              these settings. Runs that differ in nothing else share a reference, so
                              that a sweep over time step, iterations and detector needs only one;
                              `cdb plan` prints their number.

Each reference has a perturbed run, whose objects start displaced by 1e-9 of their size. Once the two
diverge, the ground truth is unknown. `horizon` is the time at which their positions differ by a
tenth of a size (root mean square over objects), or the end if they never do; errors of position,
velocity and rotation are computed up to it. The `floor` of an error is its value between the two
runs; an error below it is not significant. With a closed form, the horizon is the end and the
floors are 0.

The table below states how the samples are reduced to one number; the start is excluded. If an error
cannot be computed, it has no value and `message` gives the reason: the reference failed, or the
state of a run is not finite. Fixed objects are excluded. The size of an object is its largest side.
Errors of energy are relative to the energy of the scene: the maximum kinetic energy of the reference
at a sample, plus the energy that lifts every object by its own size; a closed form provides its own.
Energies are compared as changes since the start of each run. Heights are measured along the initial
acceleration. An exact box is the tightest box around the solid, in double precision, at the pose that
the detector last saw. Bullet enlarges its boxes by margins and by the displacement of an object in a
step, so that it always has false positive pairs.

An exact overlap is computed by a closed form in double precision from the same poses, and is deeper
than a ten thousandth of the size of the smaller object. There are closed forms for two balls, a ball
and a cuboid, two cuboids, any of these and a box wall, and any object except a compound and a plane
wall. The depth is the least translation that separates the two. If the depth along another normal is
within 1 %, the normal is not compared. A run without any exact overlap has no errors of `geometry`.

  /accuracy/NAME (..., rep)             and NAME_floor, horizon, step_size, truth, message
  /accuracy/NAME_series (..., rep, sample)    sample: time in s
  /accuracy/reference/...               states and observables of each reference and perturbed run
                                        (reference, sample, ...)

  cdb show FILE --error NAME            for each configuration its speed, its error, and whether it
                                        is on the Pareto front. --by AXIS,... selects the axes of the
                                        rows and averages over the others; --each AXIS,... prints a
                                        table for each value of an axis

)reference";

const std::string_view kResultsReference = R"reference(THE RESULTS FILE

A benchmark yields one HDF5 file, which is also valid netCDF-4 and follows CF-1.8 where it applies.
It holds the whole sweep as a tensor with named axes. For the axes quantity and detector:

  quantity(quantity)                      coordinate, one for each axis
  detector(detector)                      text; the attribute `labels` holds the words as well
  rep(rep)  phase(phase)  cycle(cycle)    phase: broad narrow detect solve integrate step
  duration(quantity, detector, rep, phase, cycle)    ns; NaN for cycles that did not run
  pairs, contacts, ... (quantity, detector, rep, cycle)
  status(quantity, detector, rep)         how the run ended; the values are listed below
  verdict                                 whether the simulation was sound: `cdb doc verdicts`
  first_bad_cycle                         the first cycle at which the verdict applies; -1 if none
  n_cycles                                number of cycles that ran; -1 if there is no run
  /run                                    the other facts of each run (quantity, detector, rep):
    state_hash                            hash of the position, orientation and velocities of every
                                          body after the last cycle; always the same for the same
                                          plan
    omitted                               parts of the engine that the run omitted: `cdb doc omit`
    needs                                 the decision about each part and its reason, one per line
    run_id, message, host, started, load_average, peak_rss, place_time, build_time, fill_fraction
    harness                               measurement overhead in ns per cycle: time stamps, and
                                          calling a detector that does nothing; included in the
                                          durations, not subtracted
  /accuracy                               errors, if the scenario asks for them: `cdb doc accuracy`
  /provenance                             build, machine, plan_text and scenario_text; plugins of
                                          the command line; models: how well the convex hulls
                                          approximate the meshes of the scene. A fact that differs
                                          between runs is an array over `run`, their run_id.

Each group with axes has their coordinates, so that a value is found by its labels: in xarray,
  open_dataset("out.h5").duration.sel(detector="dbvt", phase="step")
  open_dataset("out.h5", group="run").peak_rss.sel(detector="dbvt")
  open_dataset("out.h5", group="accuracy").energy.sel(detector="dbvt")

Every variable has a long_name, and every number has units ("1" if it is dimensionless; poses and
states of references list theirs in component_units). Counts are int32, and statuses are int8 with
flag_meanings. Durations are float64 and hold whole nanoseconds exactly, up to 104 days; bytes, rows
of contacts and masks of 32 bits are float64 too. The _FillValue, -1 in counts and NaN in float64,
marks cycles that did not run and runs that do not exist. The arrays are as long as the longest run;
shorter runs are padded with fill values. The padding is compressed, and `cdb show` prints its share.

The last 24 bytes of the file are a seal, after the end of the HDF5 data: `cdb seal`, the number of
bytes before it, and a 64-bit checksum of these. Every command compares a file with its seal before
HDF5 reads it. `cdb check out.h5` also reads every value, and compares runs, shapes and axes with the
plan in the file:
  out.h5: whole: 24 of 24 runs, of plan 0123456789ab; every byte is as it was written
Every chunk also has a Fletcher-32 checksum, which HDF5 verifies in every language; datasets without
chunks have the seal only. The attribute `digest` states that there is a seal: a file without it is
from an earlier version, and can be read. Remove the attribute from a copy that another program made
(h5repack, ncks).
A file that cdb did not write is first read in a process with limits of time and memory; links,
views, values in other files, and filters other than shuffle, deflate and fletcher32 are refused.
All values of files up to 64 MiB are read before any is shown; those of larger files are checked as
they are read.

An axis keeps the name that the scenario gives it. `cdb check` refuses names that are taken: those of
the variables and groups in the root, of the facts in /run, and, if the scenario asks for errors, of
the arrays in /accuracy.

The shard of a run, in the folder `out.runs` until the merge, has the same arrays, with every axis of
length 1. Its numbers have units and flag_meanings; dimension scales, descriptions and _FillValue are
added by the merge, which takes them from the plan. HDF5 1.10 and later reads it.

Results of schema version 1 can be read too: `cdb show` prints them, and their shards can be merged
and resumed. They store the facts of a run in the root.

`record boxes` adds the input of the broad phase: boxes over box_body (objects, then the walls that
are present), and box_filters, which state the bodies that each may collide with. `cdb trace` makes a
file of them.
`record contacts` adds a ragged array: contact_body, contact_point, contact_normal and
contact_distance over `contact_row`, cell after cell. `contacts` is the number of rows of each
cycle, and contact_first the first row of each run.
`record pairs` compares the detector with brute force, in double precision, on the boxes of each
cycle: exact_pairs is the number of exact pairs, missed_pairs the number of these that the detector
did not list, phantom_pairs the number of false positives, and duplicate_pairs the number of pairs
that were listed again. Contacts are compared with closed forms, as by the metric geometry (`cdb doc
accuracy`): missed_contacts, depth_error, normal_error. -1 and NaN mean that a cycle has no such
value. If a run records timing or memory as well, the pairs come from a second pass without a clock,
which has to end in the same state. `cdb verify FILE` does this for every detector, and `cdb show`
names the detectors that miss pairs before any timing.
Phases: broad updates the boxes and finds pairs, narrow computes contacts, detect is both together
with the time between them, and step is the whole cycle. Each phase has its own time stamps; nothing
is subtracted.

)reference";

const std::string_view kTracesReference = R"reference(TRACES

A trace records the input of the broad phase: the box of every body in every cycle of a run. On a
trace, all detectors are timed on the same motion, without the physics.

  cdb trace FILE [-b NAME] [-o OUT]     runs each point of a benchmark once, as the file states, and
                                        writes NAME.trace.h5, or, if there are several points, a file
                                        for each in the folder NAME.traces. Existing traces are kept;
                                        --fresh records them again.
  trace "NAME.trace.h5"                 in a benchmark: runs its detectors on this trace. The path is
                                        relative to the .cdb file; sweep("a", "b") is an axis of
                                        several traces. file("NAME.trace.h5", sha256: "...") refuses
                                        any other trace.

  benchmark compare {
    trace     sweep("dense.traces/dense_n-1000.trace.h5", "dense.traces/dense_n-10000.trace.h5")
    detector  sweep(dbvt, sap32)
    record    timing, counts, memory, pairs
  }

Such a benchmark may also set detector, threads, repeats, warmup, cycles, timeout, memory and record
(timing, counts, memory, pairs). All other parameters describe a world and are refused by name. The
default of cycles is the length of the trace. The plan stores the hash of the boxes, so that another
trace makes another run.
  A cycle is one call of the detector: broad, detect and step are its time, and the other phases have
no value. The time includes reading the boxes by the detector, but not arranging them for it.
place_time has no value, and build_time is the time to make and prepare the detector. `pairs` counts
the pairs that may collide; state_hash is computed from the sorted pairs of the last cycle, so that
detectors that list the same pairs have the same hash.

The file is HDF5, and also valid netCDF-4:

  boxes(cycle, body, bound)       m: lower x y z, upper x y z; float32 if the run was in single
                                  precision. Objects, then walls, without those that the run omitted.
                                  The box of a plane is infinite.
  filters(body, filter)           group, mask, fixed: two bodies may collide if the group of each is
                                  in the mask of the other, and not both are fixed
  poses(cycle, object, pose)      centre of mass and orientation quaternion after the cycle
  scenario_text, run_text         the scenario, and all settings of the run, as YAML
  attributes                      schema, schema_version, benchmark, point, run_id, state_hash, sha256,
                                  precision, timestep (s), bodies, objects, cycles, digest

A trace ends with a seal, as results do; `cdb check t.h5` verifies it.

  import h5py
  boxes = h5py.File("dense.trace.h5")["boxes"][:]

`cdb list scenarios` lists scenes to record, under `detectors`.

)reference";

}  // namespace cdb::manual
