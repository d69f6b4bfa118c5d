// A k-d tree, made anew in each cycle: space is cut in two at the median of the boxes' lower
// corners, across the axis where they spread the most, until few boxes are left; those are tested
// with each other. A box on both sides of a cut goes to both.
//
// Source: Bentley, "Multidimensional binary search trees" (1975), as in the paper's section 2.
// Cost: n log n while few boxes are cut; leaves that cutting makes no smaller are all pairs.
#pragma once

#include "library/detectors/detector.h"

namespace cdb::builtin {

/// Exact; lists each pair once. Threads: its caller's alone.
Detector* MakeKdTree(const Options& options);

}  // namespace cdb::builtin
