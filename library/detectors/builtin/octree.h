// `octree`: a loose octree, rebuilt every cycle. Each body is in a cube of at least its own size
// that contains its centre, and is tested with the bodies of all cubes that its box reaches. A cube
// is split if more than eight of its bodies would fit into its halves. Bodies are inserted in
// Morton order, so that those of a cube are close in memory.
//
// Source: Ulrich, "Loose octrees", Game Programming Gems 1 (2000); Woulfe & Manzke 2009, section 2,
// lists octrees. Cost: n log n for evenly distributed bodies; bodies in the same place are all
// tested with each other.
#pragma once

#include "library/detectors/detector.h"

namespace cdb::builtin {

/// Exact pairs, each listed once. Threads: only the caller's.
Detector* MakeOctree(const Options& options);

}  // namespace cdb::builtin
