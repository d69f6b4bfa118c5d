// Warnings to read before quoting a figure of a results file, for results documents
// (results_document.h).
#pragma once

#include "runtime/document/source.h"

namespace cdb::document {

/// `warnings`: each with its kind and a sentence, the most severe first.
Json DocumentWarnings(const DocumentSource& source);

}  // namespace cdb::document
