// The built-in detectors, which have no dependencies, by name.
#pragma once

#include <span>

#include "library/detectors/detector.h"

namespace cdb::builtin {

/// Linked into every worker; described in the catalogue. Threads: any.
std::span<const DetectorEntry> BuiltinDetectors();

}  // namespace cdb::builtin
