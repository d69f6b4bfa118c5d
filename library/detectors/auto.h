// `auto`: whichever of cdb's broad phases suits the scene as it moves.
#pragma once

#include <memory>

#include "library/detectors/detector.h"
#include "library/detectors/kernels.h"

namespace cdb::library {

/// Exact pairs. Method: `sweep` for few bodies; else `skin`, and `grid` for a while where skin's
/// lists last too short to pay, after which skin is tried again, more and more seldom. It goes by
/// counted tests, not by the clock: the same motion gives the same list in the same order. Cost:
/// that of the best of them, and skin's trials. Memory, threads: theirs.
std::unique_ptr<Detector> MakeAuto(const Options& options, const Kernels& kernels = BestKernels());

}  // namespace cdb::library
