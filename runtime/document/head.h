// The head of a results document (results_document.h): runs, machine, noise, omissions, failures.
#pragma once

#include "runtime/document/source.h"

namespace cdb::document {

/// `runs`: the number of runs by their ending.
Json DocumentRuns(const DocumentSource& source);
/// `omissions`: for each component that was omitted at some point, the points and the reason.
Json DocumentOmissions(const DocumentSource& source);
/// `findings`: the faults that the pair referee found, by detector.
Json DocumentFindings(const DocumentSource& source);
/// `failures`: at most `most` of them.
Json DocumentFailures(const DocumentSource& source, std::size_t most);
/// `noise`.
Json DocumentNoise(const DocumentSource& source);
// `machine`, `build` and `provenance`: facts by name. Facts that the file lacks are left out.
Json DocumentMachine(const store::ResultFile& file);
Json DocumentBuild(const store::ResultFile& file);
Json DocumentProvenance(const store::ResultFile& file);

}  // namespace cdb::document
