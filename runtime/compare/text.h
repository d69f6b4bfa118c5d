// The text of a comparison of two results files: sentences and tables (`cdb compare`).
#pragma once

#include "runtime/compare/compare.h"
#include "runtime/printers/document.h"

namespace cdb::compare {

/// In this order: differences between the files, and how far their times can be trusted; the
/// changes; the facts; the times of groups; the points that changed. Throws StoreError.
printers::Document CompareDocument(const Comparison& comparison, const CompareOptions& options);

}  // namespace cdb::compare
