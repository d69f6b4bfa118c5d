// A loose octree, made anew in each cycle: each body hangs in the cube of its own size that holds
// its centre, and is tested against the bodies of all cubes that its box reaches.
//
// Source: Ulrich, "Loose octrees", Game Programming Gems 1 (2000); octrees are of the paper's
// section 2. Cost: n log n for bodies spread evenly; bodies in one place are tested with each
// other.
#pragma once

#include "library/detectors/detector.h"

namespace cdb::builtin {

/// Exact; lists each pair once. Threads: its caller's alone.
Detector* MakeOctree(const Options& options);

}  // namespace cdb::builtin
