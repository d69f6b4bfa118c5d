// What the errors of a compilation are about.
#pragma once

#include <algorithm>

#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/catalogue.h"
#include "dsl/diagnostics.h"

namespace cdb::tests {

/// True if this build lacks libraries of third-party detectors, and all errors, of which there are
/// some, are about detectors that need them. Where all are built, no error is passed over.
inline bool LacksOnlyLibraries(const dsl::Diagnostics& diagnostics) {
  return diagnostics.has_errors() &&
         !std::ranges::all_of(schema::DetectorParts(), &schema::DetectorPart::is_built) &&
         std::ranges::all_of(diagnostics.all(), [](const dsl::Diagnostic& diagnostic) {
           return diagnostic.kind->severity() == dsl::Severity::kWarning ||
                  diagnostic.kind->code == scenario::kUnavailable.code;
         });
}

}  // namespace cdb::tests
