// `grid`: a uniform grid, rebuilt every cycle.
#pragma once

#include <memory>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"

namespace cdb::builtin {

/// Exact pairs. Method and source: box_grid.h; walls are handled separately (bodies.h). Suits
/// bodies that are close together and move fast, because it does not use temporal coherence. Cost:
/// linear in bodies and pairs if boxes are of similar size. Memory: about 70 bytes a body. Threads:
/// the search uses Options::threads; the list does not depend on them.
std::unique_ptr<Detector> MakeGrid(const Options& options,
                                   const kernels::Kernels& kernels = kernels::BestKernels());

}  // namespace cdb::builtin
