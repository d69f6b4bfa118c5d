#include "runtime/manual/statistics.h"

namespace cdb::manual {

const std::string_view kStatisticsReference = R"reference(THE FIGURES OF cdb show AND cdb compare

Times. Runs are repeatable to the last bit, so that a cycle does the same work in every repeat. The
time of a cycle is its median over the repeats: a stall in one repeat does not count. The time of a
point is the mean over its cycles, which is its total work; in `show --error`, divided by the time
step, it is what a simulated second takes. `show` uses this statistic in all tables; `compare` takes
the fastest repeats, see below. With one repeat, it is the mean of the run, stalls included. Pairs
and contacts are means over the cycles. The 5th and 95th percentile are over the cycles of a point;
they show how the scene changes, and are not an interval. `--stat` takes another statistic than the
mean over the cycles: median, p5, p95, min, max, or worst, which is the longest cycle of any repeat,
disturbances included. Its intervals are made in the same way. `--error` takes the mean alone, as a
simulated second takes all of its cycles.

Intervals. With 5 repeats or more, an interval of 95 %: the repeats are drawn with replacement, as
many as there are, and the statistic is computed from each draw. Whole runs are drawn, so that the
correlation between the cycles of a run is kept. The percentiles are widened for few repeats
(Hesterberg 2015, the expanded percentile interval). A draw may have a repeat several times, so
that a stall in it would outvote the others: times far from the median of their cycle are limited
first (Singh 1998, the winsorised bootstrap), up to 5 % of them. If more are disturbed, the
interval is wide; repeat the run on an idle machine. The repeats of a sweep are interleaved, and
ratios paired: both detectors have the same repeats in each draw. With 2 to 4 repeats, the table
has the range of all draws instead, which is narrower than an interval of 95 %; with one repeat,
there is none. The same file always has the same intervals.
  An interval is of this machine in the state that it was in. It does not say how another machine,
or another seed, would differ.

Errors of a configuration are the same in all repeats. If the scenario sweeps `seed`, `show
--error` averages over the seeds, and has an interval by the same bootstrap over the seeds.

Rows. Axes that make no rows (`--by`) are pooled: the mean over their cells. If `skip`, or failed
runs, left holes, a row pools only the cells that all rows of its kind have; the column `cells`
says how many (`2 of 3`). Points with different marks are different kinds and in different rows:
  frozen, crashed, ...    a verdict voids the timings (`cdb doc verdicts`); --sound drops these rows
  without solver          the run omitted a part that others kept, so that it did less work

Ratios between detectors are to `--baseline`, by default to the first detector that has all cells.
Their geometric mean is over the cells that all detectors have, sound and with the same omissions.
Ratios of other cells are in parentheses. If all runs are void, the mean is of void runs, in
parentheses.

The front of `show --error`: no other configuration is both as fast and as accurate. A
configuration off the front is a tie if each that is as fast and as accurate lies within the
intervals, in time and in error; an error without an interval is known within its floor. Void runs
are not on the front.

COMPARING FILES: cdb compare

`cdb compare a.h5 b.h5` says what changed from a to b: two builds, two machines, two versions of a
plug-in. Points are matched by the names and values of their axes. What differs between the files
is said first. Parameters that make another scene must not differ; those of how it is run may:
detector, narrow_phase, pair_order, threads, precision, solver, omit, record, repeats, timeout,
memory, accuracy. A point whose runs were void, or omitted a part in one file alone, has no times to
compare.

Facts. The last state, verdicts, errors, counts of pairs and the heap are the same in every repeat,
and compared exactly. Equal last states mean that the physics is the same to the bit; of detectors
on traces, which have no physics, the pairs of the last cycle are compared. An error that changed
within its noise floor is neither better nor worse, nor is a heap that changed by less than 1 %. The
peak memory of a process varies: it changed if it did by more than the range of its repeats, and by
more than 1 % (5 % with fewer than 5 repeats).

Times. The time of a cycle is here that of the fastest repeat, as disturbances only add time (Chen
and Revels 2016). On a shared machine whole runs are slow while a neighbour has the same core, and
medians lie among the fast runs or the slow ones by chance: those of equal code, 45 repeats each,
differed by up to 4 %, the fastest by 1.3 %. The fastest of more repeats is faster, and an extreme
has no bootstrap unless it is one of few; so it is the fastest of 2 sqrt(n) repeats, in the mean
over all choices of so many, with n the repeats of the file that has fewer. The time of a point is
the mean over its cycles. The ratio b / a of it is taken at each point and in each phase; for a
group, which is a detector (or a value of the first axis of texts), the geometric mean over its
points. The repeats of two files are independent, so that the logarithm of a ratio has the variance
of both, each by the bootstrap over the repeats of its file. Interval and test are of Student's t,
with the degrees of freedom of Welch 1947. Both files need 5 repeats; with fewer, the verdict is
`cannot tell`.

Verdicts. The test is whether the change is more than 1 %, either way: another build moves code and
data in memory, which alone changes times by about that (Mytkowicz et al. 2009).
  faster, SLOWER         the corrected p is at most 5 %
  same within 1.2 %      it is not, and the interval reaches this far from 1, which is less than
                         --fail-above (5 %)
  cannot tell            the interval reaches farther: the noise is larger than the effect

Many comparisons. Groups are the result, and a false alarm among them is expensive. Their tests, in
all phases and benchmarks of a command, are corrected by Holm 1979: the chance of any false alarm is
at most 5 %, however the tests depend on each other (`step` contains the other phases). Points show
where a change is. They are corrected by Benjamini and Hochberg 1995: of the changes found, at most
5 % are expected to be false. On made-up runs with a planted change of 5 % in one of 4 detectors (3
points each; 0.5 % between repeats, 1.5 % between runs, 3 % between cycles, 1 % stalls; 100 cases),
and with 40 % of the runs slower by up to 30 %:
  repeats                          5       6       9      15      45
  change found                    89      99     100     100     100 % of the cases
  with slow runs                   9      21      84     100     100 % of the cases
  any false alarm of a group       0       0       0       0       0 % of the cases, either way
  interval covers the truth       98      98      96      96      92 % of the groups, either way

The machine. If the median over 3 groups or more changed, everything did: the machine, or code that
all groups have in common. The column `relative` then has each group over that median, and
--relative judges by it. The harness, cdb's own overhead, does not depend on the detector: if it
moved too, suspect the machine. Better, interleave the runs of two builds, so that a change of the
machine affects both:
  for k in $(seq 9); do
    before/cdb run scene.cdb --shard $k/9 -o a.h5
    after/cdb  run scene.cdb --shard $k/9 -o b.h5
  done
  cdb merge -o a.h5 a.runs; cdb merge -o b.h5 b.runs

Exit status. 4 if a group or a point is slower and its whole interval is above --fail-above, an
error or the memory is worse by more, a verdict is worse, or a pair is missed that was not; else 0.

Several files, `cdb compare a.h5 b.h5 c.h5`, are a history: the ratio of each group to the first
file, and the files at which it changed. The exit status is that of the last file relative to the
first. Folders are compared file by file, by name.

--json has every number: benchmarks[].comparisons[] with differs, states, facts, and times: groups
and points, each with phases: ratio, interval, p, adjusted_p, verdict. NaN is null.

)reference";

}  // namespace cdb::manual
