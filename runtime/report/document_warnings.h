// What to know before a figure of a results file is quoted, for results documents
// (results_document.h).
#pragma once

#include "runtime/report/document_source.h"

namespace cdb::report {

/// `warnings`: each with its kind and a sentence, the worst first.
Json DocumentWarnings(const DocumentSource& source);

}  // namespace cdb::report
