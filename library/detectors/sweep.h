// `sweep`: sweep and prune along one axis.
#pragma once

#include <memory>

#include "library/detectors/detector.h"
#include "library/detectors/kernels.h"

namespace cdb::library {

/// Exact pairs. Method: boxes sorted by their lower end along the axis where they crowd least
/// (looked at again every 32 cycles), from last cycle's order by insertion; each is tested with
/// those that begin before it ends, eight at once. For few bodies, for those spread along a line,
/// and for infinite boxes. Cost: bodies, exchanges since the last cycle, and overlaps along the
/// axis / 8. Memory: about 70 bytes a body. Threads: the caller's alone. Source: Cohen, Lin,
/// Manocha & Ponamgi, I-COLLIDE, 1995.
std::unique_ptr<Detector> MakeSweep(const Options& options, const Kernels& kernels = BestKernels());

}  // namespace cdb::library
