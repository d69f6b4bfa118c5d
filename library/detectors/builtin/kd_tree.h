// `kd_tree`: a k-d tree of boxes, rebuilt every cycle. Space is split at the median of the lower
// corners of a sample, across the axis of greatest spread, until few boxes are left, which are
// tested with each other. A box on both sides of a split is in both subtrees.
//
// Source: Bentley, "Multidimensional binary search trees" (1975), cited by Woulfe & Manzke 2009.
// Cost: n log n if few boxes are split; in leaves that cannot be split further, all pairs are
// tested.
#pragma once

#include "library/detectors/detector.h"

namespace cdb::builtin {

/// Exact pairs, each listed once. Threads: only the caller's.
Detector* MakeKdTree(const Options& options);

}  // namespace cdb::builtin
