// A comparison of two results files in words and tables (`cdb compare`).
#pragma once

#include <string>
#include <vector>

#include "runtime/report/compare.h"
#include "runtime/report/compare_document.h"

namespace cdb::report {

/// What differs between the files and how far their times can be trusted; what changed; the facts;
/// the times of groups; the points that changed. Throws StoreError.
Document CompareDocument(const Comparison& comparison, const CompareOptions& options);

/// The lines of the section `Result`: what changed, for people who read no further.
std::vector<std::string> ResultLines(const Comparison& comparison, const CompareOptions& options);

/// The lines of what is not a time: states and facts that changed.
std::vector<std::string> FactLines(const Comparison& comparison);

/// `same within 1.2 %`, `slower`.
std::string VerdictText(const JudgedChange& change);

}  // namespace cdb::report
