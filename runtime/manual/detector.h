// The tables of `cdb list detectors` and `cdb doc detectors`.
#pragma once

#include <string>

namespace cdb::manual {

/// The catalogue's detectors: a table of the broad phases, one of the narrow phases.
std::string DetectorTables();

/// Where to find each family of the paper.
std::string FamilyTable();

}  // namespace cdb::manual
