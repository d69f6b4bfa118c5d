// The axes and points of a results document (results_document.h): columns of equal length.
#pragma once

#include "runtime/document/source.h"

namespace cdb::document {

/// `axes`.
Json DocumentAxes(const DocumentSource& source);
/// `phases`: their names and contents.
Json DocumentPhases();
/// `points`. For more than kMaxWholePoints points: step and detect only, with mean and interval,
/// and constant columns as `{"constant": value}`.
Json DocumentPoints(const DocumentSource& source);

}  // namespace cdb::document
