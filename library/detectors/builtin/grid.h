// `grid`: a uniform grid, built anew every cycle.
#pragma once

#include <memory>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"

namespace cdb::builtin {

/// Exact pairs. Method and source: box_grid.h; walls apart (bodies.h). For bodies that are close
/// together and move fast, as nothing of the last cycle is used. Cost: linear in bodies and pairs
/// as long as boxes are of a size. Memory: about 70 bytes a body. Threads: Options::threads share
/// the search; the list is the same.
std::unique_ptr<Detector> MakeGrid(const Options& options,
                                   const kernels::Kernels& kernels = kernels::BestKernels());

}  // namespace cdb::builtin
