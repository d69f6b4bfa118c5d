// `batch`, cdb's own narrow phase. It handles the pairs of all convex shapes and compounds of hulls
// with each other and with planes, except two compounds.
#pragma once

#include "library/detectors/detector.h"

namespace cdb::narrow {

/// Contacts of bodies up to kNear (pieces.h) apart, for planes and two balls as round.cc says:
/// exact depths, of pieces with curved surfaces to a hundredth, and up to four points for each pair
/// of convex pieces. They depend on the poses alone, not on earlier cycles, the order of pairs or
/// the number of threads, but for some three pairs in a million: there a search ends in other last
/// digits than what is remembered, or of two ways out that are equally long, to 1 %, in the other
/// one. Threads: called by one; uses Options::threads for the pairs of a cycle.
Detector* MakeBatch(const Options& options);

}  // namespace cdb::narrow
