// Every kind of diagnostic the compiler reports, listed once. A test holds that each has a golden
// file.
#pragma once

#include "dsl/diagnostics.h"

namespace cdb::scenario {

inline constexpr dsl::DiagnosticKind kUnknownName{"unknown-name"};
inline constexpr dsl::DiagnosticKind kWrongPlace{"wrong-place"};
inline constexpr dsl::DiagnosticKind kReservedName{"reserved-name"};
inline constexpr dsl::DiagnosticKind kSetTwice{"set-twice"};
inline constexpr dsl::DiagnosticKind kWrongKind{"wrong-kind"};
inline constexpr dsl::DiagnosticKind kWrongUnit{"wrong-unit"};
inline constexpr dsl::DiagnosticKind kOutOfDomain{"out-of-domain"};
inline constexpr dsl::DiagnosticKind kNotFinite{"not-finite"};
inline constexpr dsl::DiagnosticKind kBadArguments{"bad-arguments"};
inline constexpr dsl::DiagnosticKind kBadRange{"bad-range"};
inline constexpr dsl::DiagnosticKind kMisplacedSweep{"misplaced-sweep"};
inline constexpr dsl::DiagnosticKind kMisplacedRange{"misplaced-range"};
inline constexpr dsl::DiagnosticKind kAxisTwice{"axis-twice"};
inline constexpr dsl::DiagnosticKind kCircular{"circular"};
inline constexpr dsl::DiagnosticKind kNoSuchFile{"no-such-file"};
inline constexpr dsl::DiagnosticKind kBadTable{"bad-table"};
inline constexpr dsl::DiagnosticKind kTooManyRuns{"too-many-runs"};
inline constexpr dsl::DiagnosticKind kNoRuns{"no-runs"};
inline constexpr dsl::DiagnosticKind kCapacity{"capacity"};
inline constexpr dsl::DiagnosticKind kUnavailable{"unavailable"};
inline constexpr dsl::DiagnosticKind kBadComparison{"bad-comparison"};
inline constexpr dsl::DiagnosticKind kContradiction{"contradiction"};
inline constexpr dsl::DiagnosticKind kNeeded{"needed"};
inline constexpr dsl::DiagnosticKind kWrongForm{"wrong-form"};
inline constexpr dsl::DiagnosticKind kCannotPlace{"cannot-place"};
inline constexpr dsl::DiagnosticKind kRunsWillFail{"runs-will-fail", dsl::Severity::kWarning};
inline constexpr dsl::DiagnosticKind kDefaultSize{"default-size", dsl::Severity::kWarning};
inline constexpr dsl::DiagnosticKind kEllipsoids{"ellipsoids", dsl::Severity::kWarning};

inline constexpr const dsl::DiagnosticKind* kDiagnosticKinds[] = {
    &kUnknownName,    &kWrongPlace, &kReservedName, &kSetTwice,      &kWrongKind,
    &kOutOfDomain,    &kNotFinite,  &kBadArguments, &kBadRange,      &kMisplacedSweep,
    &kMisplacedRange, &kAxisTwice,  &kCircular,     &kNoSuchFile,    &kTooManyRuns,
    &kNoRuns,         &kCapacity,   &kUnavailable,  &kBadComparison, &kContradiction,
    &kNeeded,         &kWrongForm,  &kCannotPlace,  &kRunsWillFail,  &kDefaultSize,
    &kWrongUnit,      &kEllipsoids, &kBadTable};

}  // namespace cdb::scenario
