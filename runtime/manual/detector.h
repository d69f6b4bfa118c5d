// What `cdb list detectors` and `cdb doc detectors` print.
#pragma once

#include <string>

namespace cdb::manual {

/// The catalogue's detectors: a table of the broad phases, one of the narrow phases.
std::string DetectorTables();

/// How detectors are used, the tables, and where each family of the paper is.
std::string DetectorReference();

}  // namespace cdb::manual
