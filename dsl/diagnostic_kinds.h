// Every kind of diagnostic of the lexer and the parser, once. A test holds that each has a golden
// file in tests/golden/dsl.
#pragma once

#include "dsl/diagnostics.h"

namespace cdb::dsl {

// X(constant, id, severity): one row a kind.
#define CDB_DSL_DIAGNOSTIC_KINDS(X)                     \
  /* the lexer's */                                     \
  X(kNotUtf8, "not-utf8", kError)                       \
  X(kNulByte, "nul-byte", kError)                       \
  X(kControlCharacter, "control-character", kError)     \
  X(kUnknownCharacter, "unknown-character", kError)     \
  X(kForeignOperator, "foreign-operator", kError)       \
  X(kForeignComment, "foreign-comment", kError)         \
  X(kBadNumber, "bad-number", kError)                   \
  X(kNumberRange, "number-range", kError)               \
  X(kBadEscape, "bad-escape", kError)                   \
  X(kUnclosedText, "unclosed-text", kError)             \
  X(kSingleQuotes, "single-quotes", kError)             \
  /* names */                                           \
  X(kBadName, "bad-name", kError)                       \
  X(kMissingName, "missing-name", kError)               \
  X(kReservedWord, "reserved-word", kError)             \
  X(kMissingQuotes, "missing-quotes", kError)           \
  /* statements and blocks */                           \
  X(kUnexpectedToken, "unexpected-token", kError)       \
  X(kMisplacedStatement, "misplaced-statement", kError) \
  X(kMisplacedFrom, "misplaced-from", kError)           \
  X(kMissingBlock, "missing-block", kError)             \
  X(kBraceOnOwnLine, "brace-on-own-line", kError)       \
  X(kBracesForList, "braces-for-list", kError)          \
  X(kUnclosedBlock, "unclosed-block", kError)           \
  X(kStrayBrace, "stray-brace", kError)                 \
  X(kEqualsInSetting, "equals-in-setting", kError)      \
  X(kMissingEquals, "missing-equals", kError)           \
  X(kMissingSemicolon, "missing-semicolon", kError)     \
  X(kMissingWhen, "missing-when", kError)               \
  X(kNoLoops, "no-loops", kError)                       \
  X(kNoFunctions, "no-functions", kError)               \
  X(kOneValue, "one-value", kError)                     \
  /* values */                                          \
  X(kMissingValue, "missing-value", kError)             \
  X(kWrittenUnit, "written-unit", kError)               \
  X(kTwoValues, "two-values", kError)                   \
  X(kMissingComma, "missing-comma", kError)             \
  X(kTrailingComma, "trailing-comma", kError)           \
  X(kLineBreak, "line-break", kError)                   \
  X(kMissingBrackets, "missing-brackets", kError)       \
  X(kUnclosedBracket, "unclosed-bracket", kError)       \
  X(kStrayBracket, "stray-bracket", kError)             \
  X(kMismatchedBracket, "mismatched-bracket", kError)   \
  X(kSquareBracket, "square-bracket", kError)           \
  X(kRatioParts, "ratio-parts", kError)                 \
  X(kVectorParts, "vector-parts", kError)               \
  X(kBadRange, "bad-range", kError)                     \
  X(kBadSign, "bad-sign", kError)                       \
  X(kTextInSum, "text-in-sum", kError)                  \
  X(kBracketedValue, "bracketed-value", kError)         \
  X(kMisplacedAs, "misplaced-as", kError)               \
  X(kTooDeep, "too-deep", kError)                       \
  /* conditions */                                      \
  X(kMissingComparison, "missing-comparison", kError)   \
  X(kSingleEquals, "single-equals", kError)             \
  X(kChainedComparison, "chained-comparison", kError)   \
  X(kNotScope, "not-scope", kWarning)

#define CDB_DSL_X(constant, id, severity) \
  inline constexpr DiagnosticKind constant{id, Severity::severity};
CDB_DSL_DIAGNOSTIC_KINDS(CDB_DSL_X)
#undef CDB_DSL_X

#define CDB_DSL_X(constant, id, severity) &constant,
inline constexpr const DiagnosticKind* kDiagnosticKinds[] = {CDB_DSL_DIAGNOSTIC_KINDS(CDB_DSL_X)};
#undef CDB_DSL_X

}  // namespace cdb::dsl
