// The list of all kinds of diagnostic of the lexer and the parser. A test checks that each has a
// golden file in tests/golden/dsl.
#pragma once

#include "dsl/diagnostics.h"

namespace cdb::dsl {

// X(constant, code, id): one row per kind. A code is never changed or reused for another kind:
// users refer to it.
#define CDB_DSL_DIAGNOSTIC_KINDS(X)                      \
  /* the lexer's */                                      \
  X(kNotUtf8, "E0101", "not-utf8")                       \
  X(kNulByte, "E0102", "nul-byte")                       \
  X(kControlCharacter, "E0103", "control-character")     \
  X(kUnknownCharacter, "E0104", "unknown-character")     \
  X(kForeignOperator, "E0105", "foreign-operator")       \
  X(kForeignComment, "E0106", "foreign-comment")         \
  X(kBadNumber, "E0107", "bad-number")                   \
  X(kNumberRange, "E0108", "number-range")               \
  X(kBadEscape, "E0109", "bad-escape")                   \
  X(kUnclosedText, "E0110", "unclosed-text")             \
  X(kSingleQuotes, "E0111", "single-quotes")             \
  /* names */                                            \
  X(kBadName, "E0112", "bad-name")                       \
  X(kMissingName, "E0113", "missing-name")               \
  X(kReservedWord, "E0114", "reserved-word")             \
  X(kMissingQuotes, "E0115", "missing-quotes")           \
  /* statements and blocks */                            \
  X(kUnexpectedToken, "E0116", "unexpected-token")       \
  X(kMisplacedStatement, "E0117", "misplaced-statement") \
  X(kMisplacedFrom, "E0118", "misplaced-from")           \
  X(kMissingBlock, "E0119", "missing-block")             \
  X(kBraceOnOwnLine, "E0120", "brace-on-own-line")       \
  X(kBracesForList, "E0121", "braces-for-list")          \
  X(kUnclosedBlock, "E0122", "unclosed-block")           \
  X(kStrayBrace, "E0123", "stray-brace")                 \
  X(kEqualsInSetting, "E0124", "equals-in-setting")      \
  X(kMissingEquals, "E0125", "missing-equals")           \
  X(kMissingSemicolon, "E0126", "missing-semicolon")     \
  X(kMissingWhen, "E0127", "missing-when")               \
  X(kNoLoops, "E0128", "no-loops")                       \
  X(kNoFunctions, "E0129", "no-functions")               \
  X(kOneValue, "E0130", "one-value")                     \
  /* values */                                           \
  X(kMissingValue, "E0131", "missing-value")             \
  X(kWrittenUnit, "E0132", "written-unit")               \
  X(kTwoValues, "E0133", "two-values")                   \
  X(kMissingComma, "E0134", "missing-comma")             \
  X(kTrailingComma, "E0135", "trailing-comma")           \
  X(kLineBreak, "E0136", "line-break")                   \
  X(kMissingBrackets, "E0137", "missing-brackets")       \
  X(kUnclosedBracket, "E0138", "unclosed-bracket")       \
  X(kStrayBracket, "E0139", "stray-bracket")             \
  X(kMismatchedBracket, "E0140", "mismatched-bracket")   \
  X(kSquareBracket, "E0141", "square-bracket")           \
  X(kRatioParts, "E0142", "ratio-parts")                 \
  X(kVectorParts, "E0143", "vector-parts")               \
  X(kBadRange, "E0144", "bad-range")                     \
  X(kBadSign, "E0145", "bad-sign")                       \
  X(kTextInSum, "E0146", "text-in-sum")                  \
  X(kBracketedValue, "E0147", "bracketed-value")         \
  X(kMisplacedAs, "E0148", "misplaced-as")               \
  X(kTooDeep, "E0149", "too-deep")                       \
  /* conditions */                                       \
  X(kMissingComparison, "E0150", "missing-comparison")   \
  X(kSingleEquals, "E0151", "single-equals")             \
  X(kChainedComparison, "E0152", "chained-comparison")   \
  X(kNotScope, "W0101", "not-scope")

#define CDB_DSL_X(constant, code, id) inline constexpr DiagnosticKind constant{code, id};
CDB_DSL_DIAGNOSTIC_KINDS(CDB_DSL_X)
#undef CDB_DSL_X

#define CDB_DSL_X(constant, code, id) &constant,
inline constexpr const DiagnosticKind* kDiagnosticKinds[] = {CDB_DSL_DIAGNOSTIC_KINDS(CDB_DSL_X)};
#undef CDB_DSL_X

}  // namespace cdb::dsl
