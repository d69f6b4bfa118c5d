// Diagnostics: errors and warnings in the user's terms, each with its location in the text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "dsl/text/source.h"

namespace cdb::dsl {

enum class Severity { kError, kWarning };

/// A kind of diagnostic. Kinds are constants, and each layer lists its own once
/// (`dsl/diagnostics.h`, `compiler/scenario/diagnostic_kinds.h`). A test checks that every
/// kind has a golden file.
struct DiagnosticKind {
  std::string_view code;  ///< stable, `E0201`, or `W0201` for a warning: `cdb explain E0201`
  std::string_view id;    ///< in words, shown after the code: `[E0201 unknown-name]`
  /// An expression with this fault is wrong wherever it is used.
  bool is_of_expression = false;
  constexpr Severity severity() const {
    return code.starts_with('W') ? Severity::kWarning : Severity::kError;
  }
};

/// A second location that explains the first ("it was set here before").
struct Note {
  text::Span span;
  std::string text;
};

struct Diagnostic {
  const DiagnosticKind* kind = nullptr;
  text::Span span;      ///< the faulty part itself, not the parser's position
  std::string message;  ///< one sentence without a full stop
  std::string help;     ///< what to write instead; may be empty
  std::vector<Note> notes;
};

/// Collects the diagnostics of one compilation. The same message at the same location is kept once.
/// Errors never overlap: an error that touches a character of an earlier one usually follows from
/// it, and is dropped.
class Diagnostics {
 public:
  void Report(const DiagnosticKind& kind, const text::Span& span, std::string message,
              std::string help = {}, std::vector<Note> notes = {});

  bool has_errors() const { return error_count_ > 0; }
  int error_count() const { return error_count_; }
  int warning_count() const { return static_cast<int>(all_.size()) - error_count_; }
  /// In the order they were reported.
  const std::vector<Diagnostic>& all() const { return all_; }

 private:
  std::vector<Diagnostic> all_;
  bool OverlapsAnError(const text::Span& span) const;

  std::unordered_set<std::string> seen_;  // location and message of each
  std::map<const text::Source*, std::map<std::uint32_t, std::uint32_t>>
      taken_;  // errors: begin, end
  int error_count_ = 0;
};

/// The candidate nearest to `word` by edit distance (a transposition counts as one edit), or empty
/// if none is near enough to be a typing error.
std::string_view DidYouMean(std::string_view word, const std::vector<std::string_view>& candidates);

// The list of all kinds of diagnostic of the lexer and the parser. A test checks that each has a
// golden file in tests/golden/dsl.

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

// Diagnostics as text for people.

struct RenderOptions {
  bool color = false;  ///< ANSI colours, for a terminal
  /// The maximum number of errors, and of warnings, shown; the number left out is stated at the
  /// end.
  std::size_t most = static_cast<std::size_t>(-1);
};

/// All diagnostics, ordered by file and location, each as
///
///     examples/first.cdb:4:13: error: no object type is called 'cuboyd' [E0201 unknown-name]
///       4 |   type      cuboyd
///         |             ^^^^^^ did you mean 'cuboid'?
///
/// with its notes below in the same form. Tabs are kept in step, and wide lines are cut around the
/// fault. Ends with a newline unless it is empty; empty if there are no diagnostics.
std::string Render(const Diagnostics& diagnostics, const RenderOptions& options = {});
/// Renders a single diagnostic.
std::string Render(const Diagnostic& diagnostic, const RenderOptions& options = {});

/// Ordered by file, in order of first appearance, then by location. Those without a location come
/// first.
std::vector<const Diagnostic*> InOrder(const Diagnostics& diagnostics);

}  // namespace cdb::dsl
