// The list of all kinds of diagnostic of the compiler. A test checks that each has a golden file. A
// code is never changed or reused for another kind.
#pragma once

#include "dsl/diagnostics.h"

namespace cdb::scenario {

inline constexpr dsl::DiagnosticKind kUnknownName{"E0201", "unknown-name"};
inline constexpr dsl::DiagnosticKind kWrongPlace{"E0202", "wrong-place"};
inline constexpr dsl::DiagnosticKind kReservedName{"E0203", "reserved-name"};
inline constexpr dsl::DiagnosticKind kSetTwice{"E0204", "set-twice"};
inline constexpr dsl::DiagnosticKind kWrongKind{"E0205", "wrong-kind"};
inline constexpr dsl::DiagnosticKind kOutOfDomain{"E0206", "out-of-domain", true};
inline constexpr dsl::DiagnosticKind kNotFinite{"E0207", "not-finite", true};
inline constexpr dsl::DiagnosticKind kBadArguments{"E0208", "bad-arguments", true};
inline constexpr dsl::DiagnosticKind kBadRange{"E0209", "bad-range", true};
inline constexpr dsl::DiagnosticKind kMisplacedSweep{"E0210", "misplaced-sweep", true};
inline constexpr dsl::DiagnosticKind kMisplacedRange{"E0211", "misplaced-range"};
inline constexpr dsl::DiagnosticKind kAxisTwice{"E0212", "axis-twice"};
inline constexpr dsl::DiagnosticKind kCircular{"E0213", "circular", true};
inline constexpr dsl::DiagnosticKind kNoSuchFile{"E0214", "no-such-file", true};
inline constexpr dsl::DiagnosticKind kTooManyRuns{"E0215", "too-many-runs"};
inline constexpr dsl::DiagnosticKind kNoRuns{"E0216", "no-runs"};
inline constexpr dsl::DiagnosticKind kCapacity{"E0217", "capacity"};
inline constexpr dsl::DiagnosticKind kUnavailable{"E0218", "unavailable"};
inline constexpr dsl::DiagnosticKind kBadComparison{"E0219", "bad-comparison"};
inline constexpr dsl::DiagnosticKind kContradiction{"E0220", "contradiction", true};
inline constexpr dsl::DiagnosticKind kNeeded{"E0221", "needed"};
inline constexpr dsl::DiagnosticKind kWrongForm{"E0222", "wrong-form"};
inline constexpr dsl::DiagnosticKind kCannotPlace{"E0223", "cannot-place"};
inline constexpr dsl::DiagnosticKind kWrongUnit{"E0224", "wrong-unit", true};
inline constexpr dsl::DiagnosticKind kBadTable{"E0225", "bad-table"};
inline constexpr dsl::DiagnosticKind kRunsWillFail{"W0201", "runs-will-fail"};
inline constexpr dsl::DiagnosticKind kDefaultSize{"W0202", "default-size"};
inline constexpr dsl::DiagnosticKind kUnreachable{"W0203", "unreachable"};
inline constexpr dsl::DiagnosticKind kEllipsoids{"W0204", "ellipsoids"};
inline constexpr dsl::DiagnosticKind kNoEffect{"W0205", "no-effect"};

inline constexpr dsl::DiagnosticKind kPoorFit{"W0206", "poor-fit"};
inline constexpr dsl::DiagnosticKind kLargeAngle{"W0207", "large-angle"};
inline constexpr dsl::DiagnosticKind kOddInertia{"W0208", "odd-inertia"};

inline constexpr const dsl::DiagnosticKind* kDiagnosticKinds[] = {
    &kUnknownName,    &kWrongPlace, &kReservedName, &kSetTwice,      &kWrongKind,
    &kOutOfDomain,    &kNotFinite,  &kBadArguments, &kBadRange,      &kMisplacedSweep,
    &kMisplacedRange, &kAxisTwice,  &kCircular,     &kNoSuchFile,    &kTooManyRuns,
    &kNoRuns,         &kCapacity,   &kUnavailable,  &kBadComparison, &kContradiction,
    &kNeeded,         &kWrongForm,  &kCannotPlace,  &kRunsWillFail,  &kDefaultSize,
    &kUnreachable,    &kWrongUnit,  &kEllipsoids,   &kBadTable,      &kNoEffect,
    &kPoorFit,        &kLargeAngle, &kOddInertia};

}  // namespace cdb::scenario
