// Checks the lets of a file outside its benchmarks, whether or not a benchmark uses them.
#pragma once

#include "compiler/scenario/scenario.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// The meaning of a name is known only within a benchmark. So for lets that are used, only errors
/// that are errors anywhere are reported; for unused lets, all errors.
void CheckFileLets(const scenario::Scenario& scenario, dsl::Diagnostics& diagnostics);

}  // namespace cdb::checks
