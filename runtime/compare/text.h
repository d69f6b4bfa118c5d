// A comparison of two results files in words and tables (`cdb compare`).
#pragma once

#include "runtime/compare/compare.h"
#include "runtime/compare/document.h"

namespace cdb::compare {

/// What differs between the files and how far their times can be trusted; what changed; the facts;
/// the times of groups; the points that changed. Throws StoreError.
Document CompareDocument(const Comparison& comparison, const CompareOptions& options);

}  // namespace cdb::compare
