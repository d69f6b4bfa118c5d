// A place in the tokens of a source, and how to complain about what is there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dsl/diagnostics.h"
#include "dsl/lexer.h"
#include "dsl/syntax.h"

namespace cdb::dsl {

/// `benchmark`, `use`, `let`, `cases` and `skip`, which no parameter can be called.
bool IsReserved(std::string_view word);

/// Reads the tokens of one source in order, with any look-ahead.
class TokenCursor {
 public:
  /// Lexes the source, with its errors.
  TokenCursor(const text::Source& source, Diagnostics& diagnostics);

  /// The token `ahead` of the current one; the last is kEnd, however far one looks.
  const Token& Peek(std::size_t ahead = 0) const;
  /// The token that was taken last; kEnd before the first.
  const Token& Previous() const;
  Token Take();
  bool At(TokenKind kind) const { return Peek().kind == kind; }
  /// A word such as `step`, which is a name elsewhere.
  bool AtWord(std::string_view word, std::size_t ahead = 0) const;
  /// Where a statement can end: a line end, `;`, `}` or the end of the file.
  bool AtStatementEnd() const;
  /// A name, number, text or opening bracket.
  bool AtValueStart(std::size_t ahead = 0) const;
  /// At the end of a line whose next line can only go on with the value before it.
  bool NextLineContinues() const;
  bool FirstOnLine(const Token& token) const;

  /// Errors of the parser, and tokens up to here that the lexer has complained about.
  int fault_count() const { return error_count_ + faulty_before_[index_]; }

  std::size_t index() const { return index_; }
  void Rewind(std::size_t index) { index_ = index; }

  std::string_view Text(const Token& token) const;
  text::Span SpanOf(const Token& token) const { return {&source_, token.begin, token.end}; }
  /// From `begin` to the end of the token that was taken last.
  text::Span SpanFrom(std::uint32_t begin) const { return {&source_, begin, Previous().end}; }
  /// `'size'`, `the end of the line`: for messages.
  std::string Describe(const Token& token) const;
  std::string Quote(const Token& token) const;
  std::string Quote(const text::Span& span) const;

  void Report(const DiagnosticKind& kind, const text::Span& span, std::string message,
              std::string help = {}, std::vector<Note> notes = {}) {
    if (kind.severity() == Severity::kError) ++error_count_;
    diagnostics_.Report(kind, span, std::move(message), std::move(help), std::move(notes));
  }
  /// `expected WHAT, not 'x'`, unless the lexer has already complained about this token.
  void ReportUnexpected(std::string_view expected, std::string help = {});

  /// True where `height` more levels still fit below the current one; else reports it, at `span`,
  /// once for each statement.
  bool FitsDepth(int height, const text::Span& span);
  /// Whether this statement nests too deep, so that the rest of it is not read.
  bool gave_up() const { return gave_up_; }
  void BeginStatement() { gave_up_ = false; }

  /// A name in its own right: `my_bench` after `benchmark`. Reports what cannot be one and gives
  /// what was meant; nothing where there is no name at all. `what` is for the message: `a let`.
  /// Where a value goes on behind the name, a `-` is an operator and no part of it.
  std::optional<Name> ParseName(std::string_view what, bool within_value = false);
  /// The path at the cursor, as the head of a statement: refuses reserved words in it, and `-`.
  Name TakePath();
  /// Reports the reserved words in a path.
  void RefuseReserved(const Name& path);

  const text::Source& source() const { return source_; }

 private:
  friend class DepthScope;
  Name TakeHyphened(bool digits_too);

  const text::Source& source_;
  Diagnostics& diagnostics_;
  std::vector<Token> tokens_;
  std::vector<int> faulty_before_;  ///< by token: how many before it
  std::size_t index_ = 0;
  int error_count_ = 0;
  int depth_ = 0;
  bool gave_up_ = false;
};

/// One level deeper for as long as it lives.
class DepthScope {
 public:
  explicit DepthScope(TokenCursor& cursor) : cursor_(cursor) { ++cursor_.depth_; }
  ~DepthScope() { --cursor_.depth_; }
  DepthScope(const DepthScope&) = delete;
  DepthScope& operator=(const DepthScope&) = delete;

 private:
  TokenCursor& cursor_;
};

}  // namespace cdb::dsl
