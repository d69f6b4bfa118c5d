#include "runtime/manual/document.h"

namespace cdb::manual {

const std::string_view kDocumentReference = R"reference(THE RESULTS DOCUMENT

`cdb show --json out.h5` prints one JSON document: the figures of `cdb show`, for scripts. The page
of `cdb report` embeds the same document, and examples/read/python and examples/read/figures.R read
it. All statistics are computed by cdb (`cdb doc statistics`). Times are in ns; numbers have six
digits; missing numbers are null.

  document, generator     the version of this format, 1, and the cdb that made the results
  sources, title          the file, its benchmark and its title
  runs                    numbers of runs: all, good, void, failed, skipped, missing; repeats,
                          cycles
  warnings                caveats that affect the figures, the worst first: kind, text
  conclusions             question, answer, kind, certainty: clear (the 95 % interval of the ratio
                          excludes 1), tie (it does not), unknown (too few repeats)
  axes                    name, label, unit, is_text, kind, doc, values, and value_labels, the values
                          as text: long fractions are rounded, but distinct values stay distinct
  detector_axis           index of the axis of detectors, or null
  statistic, interval     how times and their intervals are computed, in words
  phases                  name, label, definition

  points                  columns of equal length, with an entry for each point of the grid that has
                          a run:
    at                      the index on each axis
    mark, is_void           `frozen`, `without walls`; whether a verdict voids its timings
    verdict, first_bad_cycle, repeats, cycles
    times.PHASE             mean with low and high, the ends of its interval; median, p5, p95, min,
                            max over the cycles
    time_step, ms_per_s     s; run time of a simulated second, with ms_per_s_low and ms_per_s_high
    counts, memory          means over the cycles; bytes
    errors.NAME             unit, label, value, floor

  ratios                  null without an axis of detectors; baseline, cells, matched
    phases.PHASE            columns as in points: value, low, high, is_matched
    means.PHASE             for each detector the geometric mean over the matched cells: value, low,
                            high, least, most, cells, of
  fronts                  for each error and each scene (`each`): rows with at, ms_per_s, low, high,
                          error, error_low, error_high, floor, on_front, is_tie, is_void, points
  omissions               parts that some points omitted: parts, points, why, changes, at
  findings                findings of the pair referee, by detector
  failures                place, why, and the command that executes only this run
  noise, machine, build, provenance

With more than 5000 points, the document has only the mean of step and detect, with four digits; `at`
is {"grid": [[first, count], ...]}, ranges of indices into the grid (the last axis varies fastest), and
a column with the same value throughout is {"constant": value}. More than 100,000 points are refused:
--select selects a part.

)reference";

}  // namespace cdb::manual
