// Ratios between detectors, and fronts of error against run time, for results documents
// (results_document.h).
#pragma once

#include <string>

#include "runtime/document/source.h"

namespace cdb::document {

/// `detector_axis`: its index; null if the file does not sweep detectors.
Json DocumentDetectorAxis(const DocumentSource& source);
/// `ratios`; null if no detectors are compared. `baseline`: as in show.h. Throws StoreError.
Json DocumentRatios(const DocumentSource& source, const std::string& baseline);
/// `fronts`: for each error, one for each scene (scene_axes.h).
Json DocumentFronts(const DocumentSource& source, bool only_sound);

}  // namespace cdb::document
