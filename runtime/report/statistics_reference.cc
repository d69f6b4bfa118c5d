#include "runtime/report/statistics_reference.h"

namespace cdb::report {

const std::string_view kStatisticsReference = R"reference(THE FIGURES OF cdb show

Times. Runs are repeatable to the last bit, so that a cycle does the same work in every repeat. The
time of a cycle is its median over the repeats: a stall in one repeat does not count. The time of a
point is the mean over its cycles, which is its total work; in `show --error`, divided by the time
step, it is what a simulated second takes. Both commands use this statistic in all tables. With one
repeat, it is the mean of the run, stalls included. Pairs and contacts are means over the cycles.
The 5th and 95th percentile are over the cycles of a point; they show how the scene changes, and
are not an interval. `--stat` takes another statistic than the mean over the cycles: median, p5,
p95, min, max, or worst, which is the longest cycle of any repeat, disturbances included. Its
intervals are made in the same way. `--error` takes the mean alone, as a simulated second takes all
of its cycles.

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

)reference";

}  // namespace cdb::report
