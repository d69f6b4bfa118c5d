// Detectors of the C interface (library/detectors/detector_c.h), as detectors of the C++ one.
#pragma once

#include <memory>

#include "library/detectors/detector.h"
#include "library/detectors/detector_c.h"

namespace cdb::detectors {

/// Returns null if its function `make` does. `row` must outlive the detector. Errors: its calls
/// throw std::runtime_error with the text that a function returns. Threads: as Detector.
std::unique_ptr<Detector> MakeCDetector(const cdb_detector& row, const Options& options);

}  // namespace cdb::detectors
