// Bullet's contacts as a detector (bullet.h).
#pragma once

#include "library/detectors/detector.h"

namespace cdb::library {

Detector* MakeBulletContacts(const Options& options);

}  // namespace cdb::library
