// `batch`, cdb's own narrow phase. It handles the pairs of all convex shapes and compounds of hulls
// with each other and with planes, except two compounds.
#pragma once

#include "library/detectors/detector.h"

namespace cdb::narrow {

/// Contacts of bodies up to kNear (pieces.h) apart, for planes and two balls as round.cc says:
/// exact depths, of pieces with curved surfaces to a hundredth, and up to four points for each pair
/// of convex pieces. They depend on the poses alone, not on earlier cycles, the order of pairs or
/// the number of threads, except for about three pairs in a million, for which a fresh search has
/// other last digits, or finds another way out whose length is the same to 1 %. Threads: called by
/// one; uses Options::threads for the pairs of a cycle.
Detector* MakeBatch(const Options& options);

}  // namespace cdb::narrow
