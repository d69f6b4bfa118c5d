// FCL's broad phases.
#pragma once

#include "library/detectors/detector.h"

namespace cdb::third_party {

Detector* MakeFclTree(const Options& options);
Detector* MakeFclTreeArray(const Options& options);
Detector* MakeFclSsap(const Options& options);
Detector* MakeFclSpatialHash(const Options& options);
Detector* MakeFclIntervalTree(const Options& options);

}  // namespace cdb::third_party
