// Entries of the detectors included in cdb. Name, doc, phases and limit come from the catalogue.
#pragma once

#include <string_view>

#include "compiler/schema/catalogue_table.h"
#include "library/detectors/detector.h"

namespace cdb::detectors {

/// A name that is not in the catalogue is a compile error.
consteval DetectorEntry CatalogueEntry(std::string_view name, Detector* (*make)(const Options&)) {
  for (const schema::DetectorInfo& row : schema::kDetectorTable) {
    if (row.name != name) continue;
    return {.name = row.name.data(),
            .doc = row.doc.data(),
            .phases = !row.HasPhase("narrow") ? kBroad
                      : row.HasPhase("broad") ? kBroad | kNarrow
                                              : kNarrow,
            .max_bodies = row.max_bodies,
            .make = make};
  }
  throw "no such detector in the catalogue";
}

}  // namespace cdb::detectors
