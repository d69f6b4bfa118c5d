// What the errors of a compilation are about.
#pragma once

#include <algorithm>

#include "compiler/scenario/diagnostic_kinds.h"
#include "dsl/diagnostics.h"

namespace cdb::tests {

/// True if all errors are about detectors that need libraries which this build does not have.
inline bool LacksOnlyLibraries(const dsl::Diagnostics& diagnostics) {
  return diagnostics.has_errors() &&
         std::ranges::all_of(diagnostics.all(), [](const dsl::Diagnostic& diagnostic) {
           return diagnostic.kind->severity() == dsl::Severity::kWarning ||
                  diagnostic.kind->code == scenario::kUnavailable.code;
         });
}

}  // namespace cdb::tests
