#include "runtime/manual/suite.h"

namespace cdb::manual {

const std::string_view kSuiteReference = R"reference(THE STANDARD SUITE

  cdb suite                       runs all scenes, in less than eight minutes; resumes where it stopped
  cdb suite --only games,stack    these kinds and scenes
  cdb suite --long -o long        11 repeats and three seeds in place of 5 and one
  cdb suite --detector mine --plugin libmine.so    adds a detector of your own to those of the suite
  cdb suite --retry noisy         repeats the runs that were disturbed by the machine
  cdb suite --check FOLDER        checks whether results are complete and comparable
  cdb suite --against FOLDER      verifies results of another machine against those of -o
  cdb suite --seed 7 -o fresh     runs the same scenes from another seed

The suite is a fixed, versioned set of scenes, grouped by kinds of application. Each scene is a file of
the library (`cdb doc standard/games/debris`, `cdb run standard/games/debris`). All scenes of a kind
sweep the same configurations: detectors, or settings of Bullet in the kind `stiff`. The first one is
the baseline, Bullet's default.
  The folder (`suite` unless -o names another) gets a results file for each scene, `suite.json` with all
figures, and `suite.html`, a page with the recommendation for each scene and budget, the scores, and the
report of each scene. Other results files in the folder are ignored.

SCORE

  speedup(configuration, scene) = time of the baseline / time of the configuration
  score(configuration, kind)    = geometric mean of the speedups over the scenes of the kind

Both times are run times of a simulated second, the mean step over the time step (`cdb doc statistics`).
They come from the same file, and so from the same machine. The 95 % intervals are by the bootstrap over
whole repeats, paired between the configurations. With few repeats, an interval may begin or end at the
figure itself. There is no score over all kinds, as no application is of all kinds.
  A configuration that is wrong in one scene has no score in its kind, and the table says why:
  not run                               a scene of the kind has no results
  missing, failed, crashed, timed_out   a run did not end by itself, or is not there
  tunnelled, drifting, ...              the verdict of a run is worse than the scene allows
  pairs_missed, position, energy        the error of a run is over the bound of the scene
  ran without ...                       it omitted a part of the engine that others kept
  noisy                                 the machine disturbed more than half of its runs
Times of the baseline count even if it is wrong in a scene, as Bullet's default; it then has no score.
Speedups of disturbed runs are shown in brackets and are not part of any score.

WHICH ONE TO TAKE

The suite recommends the most accurate of the correct configurations whose slow steps fit into the time
budget; of equally accurate ones, the fastest, and those that tie with it: the 95 % intervals of the
ratios of their times include 1. A slow step is the 99th percentile over the cycles, each the median of
its repeats. In 1/30 s at 60 Hz, two such steps must fit. The whole budget is available to the physics.

WHAT MAKES RESULTS COMPARABLE: --check

Results are complete and comparable if
  - all scenes are there, and every byte is as it was written;
  - their plans are those of this version of the suite, with no run missing, and no additional runs
    except those of further detectors;
  - all scenes were run by a Release build of committed sources, one run at a time, with the same cdb
    and Bullet, on the same machine;
  - no configuration has mostly noisy runs;
  - `suite.json` is the summary of exactly these files.
Otherwise the exit status is 3.

WHAT VERIFIES RESULTS: --against

Runs of the same plan on the same build end in the same state, to the last bit. If they do not (other
compilers, libraries or instruction sets), no configuration with a score may be wrong here, and no error
may be twice as large, unless both are below a tenth of the bound. Speedups must agree: their intervals
overlap, or they differ by less than 10 % on processors of one model and 50 % on others. With another
seed (--seed), only speedups and errors are compared, which reveals a detector that was tuned to the
published seed. The exit status is 4 if anything disagrees, and 3 if a score could not be compared
because runs here were noisy or are missing.

HOW IT COULD BE GAMED

These attempts do not work: choosing cycles, repeats or seeds (they are part of the plan, which is
compared run by run); quoting the best of several runs (times are medians over all repeats); doing less
work than the others (missed pairs are counted against exact pairs, verdicts are judged from the motion,
omissions must be alike); working while no clock runs (errors are measured in a second pass, which must
end in the same state as the timed one); being fast in a single scene (the score is a geometric mean, and
there is none if a scene is missing); another baseline (it is in the same file); an older cdb (the
version is compared); knowing the seed (--seed).
  These could work: numbers that were written into a file which was then sealed again, or a modified cdb,
are found by --against only; a detector that recognises the scenes of the suite by their sizes is found
only by scenes of your own; a noisy machine disturbs the baseline as well as the other configurations,
and an adversary could disturb the baseline below the limits of noise (`cdb doc noise`), by up to a few
per cent.

)reference";

}  // namespace cdb::manual
