#include "runtime/manual/suite.h"

namespace cdb::manual {

const std::string_view kSuiteReference = R"reference(THE STANDARD SUITE

  cdb suite                       runs all scenes, in about seven minutes; resumes where it stopped
  cdb suite --only games,stack    these kinds and scenes
  cdb suite --long -o long        11 repeats and three seeds in place of 5 and one
  cdb suite --detector mine --plugin libmine.so    with a detector of your own beside those of the suite
  cdb suite --retry noisy         measures the runs again that the machine disturbed
  cdb suite --check FOLDER        whether results are complete and comparable
  cdb suite --against FOLDER      verifies results of another machine by those of -o
  cdb suite --seed 7 -o fresh     the same scenes from another seed

The suite is a fixed set of scenes, grouped by kinds of application, and has a version. Each scene is a
file of the library (`cdb doc standard/games/debris`, `cdb run standard/games/debris`). It sweeps the
same configurations in all scenes of a kind: detectors, or settings of Bullet in the kind `stiff`. The
first one is the baseline, Bullet's default.
  The folder (`suite` unless -o names another) gets a results file for each scene, `suite.json` with all
figures, and `suite.html`, a page with the choice for each scene and budget, the scores, and the report
of each scene. More results files in the folder are not looked at.

SCORE

  speedup(configuration, scene) = time of the baseline / time of the configuration
  score(configuration, kind)    = geometric mean of the speedups over the scenes of the kind

Both times are of a simulated second, of the same file, and so of the same machine: the mean step over
the time step (`cdb doc statistics`). Intervals of 95 % are by the bootstrap over whole repeats, paired
between the configurations. There is no score over all kinds: nobody has an application of all kinds.
  A configuration that is wrong in one scene has no score in its kind, and the table says why:
  not run                               a scene of the kind has no results
  missing, failed, crashed, timed_out   a run did not end by itself, or is not there
  tunnelled, drifting, ...              the verdict of a run is worse than the scene allows
  pairs_missed, position, energy        the error of a run is over the bound of the scene
  ran without ...                       it left out a part of the engine that others kept
  noisy                                 the machine disturbed more than half of its runs
Times of the baseline count even where it is wrong, as they are what Bullet takes by default; it has no
score then. Speedups of disturbed runs are shown in brackets and are part of no score.

WHICH ONE TO TAKE

Of the configurations that are right, the most accurate one whose slow steps fit into the time; of
equally accurate ones the fastest. A slow step is the 99th percentile over the cycles, each the median
of its repeats. In 1/30 s at 60 Hz, two of them must fit. The whole of the time is given to physics.

WHAT MAKES RESULTS COMPARABLE: --check

All scenes are there, every byte as it was written; their plans are those of this version of the suite,
with no run missing, and with no other runs than those of further detectors; a Release build, one
run at a time, the same cdb, Bullet and machine in all scenes; no configuration whose runs were mostly
noisy; and `suite.json` is the summary of exactly these files. Exit status 3 where something is not so.

WHAT VERIFIES RESULTS: --against

Runs of the same plan on the same build end in the same state, to the last bit. Where they do not (other
compilers, libraries or instruction sets), no configuration with a score may be wrong here, and no error
may be twice as large, unless both are below a tenth of the bound. Speedups must agree: their intervals
overlap, or they differ by less than 10 % on processors of one model and 50 % on others. With another
seed (--seed), speedups and errors alone are compared, which shows a detector that was tuned to the
published seed. Exit status 4 where something disagrees, 3 where a score could not be compared, because
runs here were noisy or are missing.

HOW IT COULD BE GAMED

Closed: choosing cycles, repeats or seeds (part of the plan, which is compared run by run); quoting the
best of several runs (medians over all repeats); doing less than the others (missed pairs are counted
against exact ones, verdicts are judged from the motion, omissions must be alike); working in the
referee's time (errors are measured in a second pass, which must end in the state of the timed one);
being fast in one scene alone (a geometric mean, and no score with one scene missing); another baseline
(the same file has it); an older cdb (the version is compared); knowing the seed (--seed).
  Not closed: who writes numbers into a file and seals it again is found by --against alone, and so is
who changes cdb itself; a detector may recognise the suite's scenes by their sizes, and only scenes of
your own tell; a noisy machine disturbs the baseline as well as the rest, and an adversary could
disturb the baseline below the limits of noise (`cdb doc noise`): up to a few per cent.

)reference";

}  // namespace cdb::manual
