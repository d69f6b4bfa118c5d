#include "runtime/manual/statistics.h"

namespace cdb::manual {

const std::string_view kStatisticsReference = R"reference(THE FIGURES OF cdb show AND cdb compare

Times. Runs are repeatable to the last bit, so that a cycle does the same work in every repeat. The
time of a cycle is its median over the repeats: a stall in one repeat does not count. The time of a
point is the mean over its cycles, which represents its total work. `show --error` divides it by the
time step, which gives the run time of a simulated second. `show` uses this statistic in all tables;
`compare` takes the fastest repeats, see below. With one repeat, it is the mean of the run, stalls
included. Pairs and contacts are means over the cycles. The 5th and 95th percentile are over the
cycles of a point; they show how the scene changes, and are not an interval. `--stat` selects another
statistic than the mean over the cycles: median, p5, p95, min, max, or worst, which is the longest
cycle of any repeat, disturbances included. Its intervals are computed in the same way. `--error`
always uses the mean, as a simulated second consists of all of its cycles.

Intervals. With 5 repeats or more, there is a 95 % interval by the bootstrap: the repeats are drawn
with replacement, as many as there are, and the statistic is computed from each draw. Whole runs are
drawn, so that the correlation between the cycles of a run is preserved. The percentiles are widened
for few repeats (Hesterberg 2015, the expanded percentile interval). A draw may contain a repeat
several times, so that a stall in it would outvote the others: times far from the median of their
cycle are limited first (Singh 1998, the winsorised bootstrap), up to 5 % of them. If more are
disturbed, the interval is wide; repeat the run on an idle machine. The repeats of a sweep are
interleaved, and ratios are paired: both detectors have the same repeats in each draw. With 2 to 4
repeats, the table has the range of all draws instead, which is narrower than a 95 % interval; with
one repeat, there is none. The same file always has the same intervals.
  An interval applies to this machine in the state during the run. It does not tell how another
machine, or another seed, would differ.

Errors of a configuration are the same in all repeats. If the scenario sweeps `seed`, `show
--error` averages over the seeds, with an interval by the same bootstrap over the seeds.

Rows. `--by` selects the axes of the rows; the other axes are pooled, by the mean over their cells.
If `skip` or failed runs left holes, a row pools only the cells that all rows of its kind have; the
column `cells` has their number (`2 of 3`). Points with different marks are of different kinds, and
in different rows:
  frozen, crashed, ...    a verdict voids the timings (`cdb doc verdicts`); --sound drops these rows
  without solver          the run omitted a part that others kept, so that it did less work

Ratios between detectors are relative to `--baseline`, by default the first detector that has all
cells. Their geometric mean is over the cells in which all detectors are sound and have the same
omissions. Ratios of other cells are in parentheses. If all runs are void, the mean is over void runs,
in parentheses.

A configuration is on the front of `show --error` if no other configuration is both as fast and as
accurate. A configuration off the front is a tie if every configuration that is as fast and as
accurate lies within its intervals, in time and in error; an error without an interval is known within
its floor. Void runs are not on the front.

COMPARING FILES: cdb compare

`cdb compare a.h5 b.h5` reports the changes from a to b: two builds, two machines, two versions of a
plug-in. Points are matched by the names and values of their axes. Differences between the files are
listed first. Parameters that make another scene must not differ; these parameters may:
detector, narrow_phase, pair_order, threads, precision, solver, omit, record, repeats, timeout,
memory, accuracy. A point whose runs were void, or omitted a part in only one of the files, has no
times to compare.

Facts. The last state, verdicts, errors, counts of pairs and the heap are the same in every repeat,
and are compared exactly. Equal last states mean that the physics is the same to the last bit. For
detectors on traces, which have no physics, the pairs of the last cycle are compared. An error that
changed within its noise floor is neither better nor worse, nor is a heap that changed by less than
1 %. The peak memory of a process varies: it counts as changed if it changed by more than the range of
its repeats, and by more than 1 % (5 % with fewer than 5 repeats).

Times. `compare` uses the fastest repeat of each cycle, as disturbances only add time (Chen and Revels
2016). On a shared machine, whole runs are slow while a neighbour uses the same core, and medians fall
among the fast or the slow runs by chance: medians of equal code, 45 repeats each, differed by up to
4 %, the fastest repeats by 1.3 %. But the fastest of more repeats is faster, and the bootstrap is not
valid for an extreme, unless it is the extreme of few. The time of a cycle is therefore the fastest of
2 sqrt(n) repeats, averaged over all choices of that many, where n is the number of repeats of the file
that has fewer. The time of a point is the mean over its cycles. The ratio b / a is computed at each
point and in each phase; for a group, which is a detector (or a value of the first axis of texts), it
is the geometric mean over its points. The repeats of two files are independent, so that the variance
of the logarithm of a ratio is the sum of those of both files, each by the bootstrap over the repeats
of its file. Interval and test use Student's t, with the degrees of freedom of Welch 1947. Both files
need 5 repeats; with fewer, the verdict is `cannot tell`.

Verdicts. The test is whether the change is more than 1 %, either way: another build moves code and
data in memory, which alone changes times by about that (Mytkowicz et al. 2009).
  faster, SLOWER         the corrected p is at most 5 %
  same within 1.2 %      p is larger, and the interval reaches this far from 1, which is less than
                         --fail-above (5 %)
  cannot tell            the interval reaches farther: the noise is larger than the effect

Many comparisons. Groups are the result, and a false alarm among them is expensive. Their tests, in
all phases and benchmarks of a command, are corrected by Holm 1979: the chance of any false alarm is
at most 5 %, however the tests depend on each other (`step` contains the other phases). Points show
where a change is. They are corrected by Benjamini and Hochberg 1995: of the changes found, at most
5 % are expected to be false. On synthetic runs with a planted change of 5 % in one of 4 detectors (3
points each; 0.5 % between repeats, 1.5 % between runs, 3 % between cycles, 1 % stalls; 100 cases),
and with 40 % of the runs slower by up to 30 %:
  repeats                          5       6       9      15      45
  change found                    89      99     100     100     100 % of the cases
  with slow runs                   9      21      84     100     100 % of the cases
  any false alarm of a group       0       0       0       0       0 % of the cases, either way
  interval covers the truth       98      98      96      96      92 % of the groups, either way

The machine. If the median over 3 groups or more changed, the cause is common to all groups: the
machine, or shared code. The column `relative` then has the ratio of each group to that median, and
--relative judges by it. The harness, cdb's own overhead, does not depend on the detector: if it
changed too, suspect the machine. It is better to interleave the runs of two builds, so that a change
of the machine affects both:
  for k in $(seq 9); do
    before/cdb run scene.cdb --shard $k/9 -o a.h5
    after/cdb  run scene.cdb --shard $k/9 -o b.h5
  done
  cdb merge -o a.h5 a.runs; cdb merge -o b.h5 b.runs

Exit status. 4 if a group or a point is slower and its whole interval is above --fail-above, if an
error or the memory is worse by more than that, if a verdict is worse, or if a pair is missed that was
not missed before; otherwise 0.

Several files, `cdb compare a.h5 b.h5 c.h5`, are a history: the ratio of each group to the first
file, and the files at which it changed. The exit status is that of the last file relative to the
first. Folders are compared file by file, by name.

--json prints every number: benchmarks[].comparisons[] with differs, states, facts, and times: groups
and points, each with phases: ratio, interval, p, adjusted_p, verdict. NaN is null.

)reference";

}  // namespace cdb::manual
