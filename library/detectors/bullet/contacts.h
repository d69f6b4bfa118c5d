// Bullet's contacts as a detector (bullet.h).
#pragma once

#include "library/detectors/detector.h"

namespace cdb::bullet {

Detector* MakeBulletContacts(const Options& options);

}  // namespace cdb::bullet
