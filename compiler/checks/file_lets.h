// The lets of a file outside its benchmarks, whether a benchmark uses them or not.
#pragma once

#include "compiler/scenario/scenario.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// What a name means is known in a benchmark only, so of lets that are used, only faults that are
/// faults anywhere are reported; of lets that nothing uses, all.
void CheckFileLets(const scenario::Scenario& scenario, dsl::Diagnostics& diagnostics);

}  // namespace cdb::checks
