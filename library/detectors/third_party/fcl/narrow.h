// FCL's narrow phases.
#pragma once

#include "library/detectors/detector.h"

namespace cdb::third_party {

Detector* MakeFclGjk(const Options& options);
Detector* MakeFclAabb(const Options& options);
Detector* MakeFclObb(const Options& options);
Detector* MakeFclRss(const Options& options);
Detector* MakeFclKdop(const Options& options);

}  // namespace cdb::third_party
