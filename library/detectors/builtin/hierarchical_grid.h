// `hierarchical_grid`: a grid for each size of box.
#pragma once

#include <memory>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"

namespace cdb::builtin {

/// Exact pairs. Method: boxes of like length, within a factor of four, share a grid (box_grid.h); a
/// grid's pairs are found within it, and each box is looked up in the grids of all larger ones. For
/// sizes over several orders, where `grid` has to test the larger ones with all. Cost: bodies times
/// the sizes above them, and the pairs. Memory: about 130 bytes a body. Errors: bad_alloc. Threads:
/// the caller's alone.
/// Source: Ericson, Real-Time Collision Detection, section 7.2; Woulfe & Manzke 2009, section 2.
std::unique_ptr<Detector> MakeHierarchicalGrid(
    const Options& options, const kernels::Kernels& kernels = kernels::BestKernels());

}  // namespace cdb::builtin
