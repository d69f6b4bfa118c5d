// What ran, on what machine, how quiet it was, what was left out and what failed, for results
// documents (results_document.h).
#pragma once

#include "runtime/document/source.h"

namespace cdb::document {

/// `runs`: how many there are, by how they ended.
Json DocumentRuns(const DocumentSource& source);
/// `omissions`: for each part of the engine that some point ran without, the points and the reason.
Json DocumentOmissions(const DocumentSource& source);
/// `findings`: what the referee of pairs found, by detector.
Json DocumentFindings(const DocumentSource& source);
/// `failures`: at most `most` of them.
Json DocumentFailures(const DocumentSource& source, std::size_t most);
/// `noise`.
Json DocumentNoise(const DocumentSource& source);
// `machine`, `build` and `provenance`: facts by name; those that the file lacks are left out.
Json DocumentMachine(const store::ResultFile& file);
Json DocumentBuild(const store::ResultFile& file);
Json DocumentProvenance(const store::ResultFile& file);

}  // namespace cdb::document
