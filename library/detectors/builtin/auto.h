// `auto`: chooses among the built-in broad phases according to the motion of the scene.
#pragma once

#include <memory>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"

namespace cdb::builtin {

/// Exact pairs. Method: `sweep` for few bodies, otherwise `skin`. If skin's lists expire too soon
/// to pay off, `grid` for a while. If many bodies share the cells of the grid, such as bodies along
/// a slanted line, `sweep`, provided that a sample shows few overlaps along an axis. Skin is
/// then tried again at growing intervals. Decisions are based on numbers of tests, not on time, so
/// that the same motion yields the same list in the same order. Cost: that of the best of them,
/// plus the trials. Memory: up to the sum of theirs. Errors: bad_alloc. Threads: as theirs.
std::unique_ptr<Detector> MakeAuto(const Options& options,
                                   const kernels::Kernels& kernels = kernels::BestKernels());

}  // namespace cdb::builtin
