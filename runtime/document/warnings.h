// What to know before a figure of a results file is quoted, for results documents
// (results_document.h).
#pragma once

#include "runtime/document/source.h"

namespace cdb::document {

/// `warnings`: each with its kind and a sentence, the worst first.
Json DocumentWarnings(const DocumentSource& source);

}  // namespace cdb::document
