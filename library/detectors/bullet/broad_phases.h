// Bullet's broad phases as detectors (bullet.h).
#pragma once

#include "library/detectors/detector.h"

namespace cdb::bullet {

Detector* MakeBulletSimple(const Options& options);
Detector* MakeBulletSap(const Options& options);
Detector* MakeBulletSap32(const Options& options);
Detector* MakeBulletDbvt(const Options& options);

}  // namespace cdb::bullet
