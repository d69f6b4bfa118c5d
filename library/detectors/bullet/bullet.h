// Bullet's own broad phases, and two of its contact algorithms, behind cdb's interface: for boxes
// that no Bullet world holds, as a trace's, and to compare a world through the interface with one
// without.
#pragma once

#include <span>

#include "library/detectors/detector.h"

namespace cdb::bullet {

/// `simple`, `sap`, `sap32` and `dbvt`, as the catalogue has them, and `bullet`: contacts of two
/// balls or two cuboids, of default margin, as Bullet computes them to the bit. Built twice, in
/// Bullet's two precisions; boxes are rounded to it outwards. Threads: one for each detector.
std::span<const DetectorEntry> BulletDetectors();

}  // namespace cdb::bullet
