// The times of single cycles, for results documents of a page (results_document.h).
#pragma once

#include "runtime/document/source.h"

namespace cdb::document {

/// `cycles`: the time of each cycle (median over the repeats), averaged in at most 200 bins, for at
/// most 60 points; if there are more, the first ones of each detector. Null without timings, and
/// for more than kMaxWholePoints points.
Json DocumentCycles(const DocumentSource& source);

/// `distributions`: quantiles over the cycles, and the mean of each repeat. All phases for at most
/// 500 points, step and detect for at most 2000; null for more, and without timings.
Json DocumentDistributions(const DocumentSource& source);

}  // namespace cdb::document
