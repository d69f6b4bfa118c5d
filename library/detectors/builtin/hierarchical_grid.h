// `hierarchical_grid`: a uniform grid for each range of box sizes.
#pragma once

#include <memory>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"

namespace cdb::builtin {

/// Exact pairs. Method: boxes of similar length, within a factor of four, share a grid
/// (box_grid.h). Pairs are found within each grid, and by querying the grids of all larger boxes.
/// Suits sizes that span several orders of magnitude, for which `grid` has to test the larger boxes
/// with all others. Cost: bodies times the number of larger grids, plus the pairs. Memory: about
/// 130 bytes a body. Errors: bad_alloc. Threads: only the caller's. Source: Ericson, Real-Time
/// Collision Detection, section 7.2; Woulfe & Manzke 2009, section 2.
std::unique_ptr<Detector> MakeHierarchicalGrid(
    const Options& options, const kernels::Kernels& kernels = kernels::BestKernels());

}  // namespace cdb::builtin
