// The series that a scene records.
#pragma once

#include "compiler/plan/plan.h"
#include "compiler/schema/series.h"

namespace cdb::analysis {

/// The kinds of run, which can record different series.
enum class RunKind { kLive, kOnBoxes, kOnPairs, kConfigurations, kSoft, kChanging };
RunKind KindOf(const plan::Scene& scene);

/// True if `scene` requests the series, and a run of its kind can record it.
bool IsRecordedBy(const schema::Series& series, const plan::Scene& scene);

/// True if the phases of a cycle are measured, for times or counters.
bool MeasuresPhases(const plan::Scene& scene);

}  // namespace cdb::analysis
