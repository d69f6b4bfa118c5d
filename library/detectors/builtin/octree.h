// `octree`: a loose octree, rebuilt every cycle. Each body is in a cube of its own size or larger
// that contains its centre, and is tested with the bodies of all cubes that its box reaches. A cube
// is halved where more than eight bodies would fit into its halves. Bodies are inserted in Morton's
// order, so that those of a cube lie together in memory.
//
// Source: Ulrich, "Loose octrees", Game Programming Gems 1 (2000); the paper's section 2 lists
// octrees. Cost: n log n for evenly distributed bodies; bodies in one place are tested with each
// other.
#pragma once

#include "library/detectors/detector.h"

namespace cdb::builtin {

/// Exact pairs, each listed once. Threads: only the caller's.
Detector* MakeOctree(const Options& options);

}  // namespace cdb::builtin
