// `auto`: whichever of cdb's broad phases suits the scene as it moves.
#pragma once

#include <memory>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"

namespace cdb::builtin {

/// Exact pairs. Method: `sweep` for few bodies, else `skin`. Where skin's lists last too short to
/// pay, `grid` for a while, and where bodies crowd in the grid's cells, as those along a slanted
/// line do, `sweep`, if one cycle of it shows that they do not crowd along its axis; then skin is
/// tried again, more and more seldom. It goes by counted tests, not by the clock: the same motion
/// gives the same list in the same order. Cost: that of the best of them, and of the trials.
/// Memory: up to all of theirs. Errors: bad_alloc. Threads: theirs.
std::unique_ptr<Detector> MakeAuto(const Options& options,
                                   const kernels::Kernels& kernels = kernels::BestKernels());

}  // namespace cdb::builtin
