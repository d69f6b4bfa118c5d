// Bullet's own broad phases and two of its contact algorithms behind cdb's detector interface: for
// boxes without a Bullet world, such as those of traces, and to compare worlds with and without the
// interface.
#pragma once

#include <span>

#include "library/detectors/detector.h"

namespace cdb::bullet {

/// `simple`, `sap`, `sap32` and `dbvt` of the catalogue, and `bullet`: contacts of two balls or two
/// cuboids with the default margin, identical to Bullet's to the last bit. Built for both
/// precisions of Bullet; boxes are rounded outwards. Threads: one for each detector.
std::span<const DetectorEntry> BulletDetectors();

}  // namespace cdb::bullet
