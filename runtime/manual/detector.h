// The text of `cdb list detectors` and `cdb doc detectors`.
#pragma once

#include <string>

namespace cdb::manual {

/// The catalogue's detectors: a table of the broad phases, one of the narrow phases.
std::string DetectorTables();

/// The use of detectors, the tables, and where to find each family of the paper.
std::string DetectorReference();

}  // namespace cdb::manual
