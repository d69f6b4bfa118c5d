// cdb's own detectors, those that no package is needed for, by name.
#pragma once

#include <span>

#include "library/detectors/detector.h"

namespace cdb::builtin {

/// Linked into every worker; described in the catalogue. Threads: any.
std::span<const DetectorEntry> BuiltinDetectors();

}  // namespace cdb::builtin
