// A cursor over the tokens of a source, which reports errors at its position.
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

/// True for `benchmark`, `use`, `let`, `cases` and `skip`, which cannot be names of parameters.
bool IsReserved(std::string_view word);

/// Reads the tokens of one source in order, with unlimited lookahead.
class TokenCursor {
 public:
  /// Lexes the source, and reports its lexical errors.
  TokenCursor(const text::Source& source, Diagnostics& diagnostics);

  /// The token `ahead` tokens after the current one; kEnd past the end.
  const Token& Peek(std::size_t ahead = 0) const;
  const Token& TokenAt(std::size_t index) const { return tokens_[index]; }
  /// The token taken last; kEnd before the first.
  const Token& Previous() const;
  Token Take();
  bool At(TokenKind kind) const { return Peek().kind == kind; }
  /// True at a word such as `step`, which is an ordinary name elsewhere.
  bool AtWord(std::string_view word, std::size_t ahead = 0) const;
  /// True where a statement can end: at a line end, `;`, `}` or the end of the file.
  bool AtStatementEnd(std::size_t ahead = 0) const;
  /// True at a name, number, text or opening bracket.
  bool AtValueStart(std::size_t ahead = 0) const;
  /// True at the end of a line if the next line can only continue the value before it.
  bool NextLineContinues() const;
  bool FirstOnLine(const Token& token) const;

  /// The number of errors of the parser, plus the tokens before this one reported by the lexer.
  int fault_count() const { return error_count_ + faulty_before_[index_]; }

  std::size_t index() const { return index_; }
  void Rewind(std::size_t index) { index_ = index; }

  std::string_view Text(const Token& token) const;
  /// The text of a span for the help of a message: `…` if it is long or has a line break.
  std::string Excerpt(const text::Span& span) const;
  text::Span SpanOf(const Token& token) const { return {&source_, token.begin, token.end}; }
  /// From `begin` to the end of the token taken last.
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
  /// Reports `expected WHAT, not 'x'`, unless the lexer has already reported this token.
  void ReportUnexpected(std::string_view expected, std::string help = {});

  /// True if `height` more levels fit below the current one; otherwise reports at `span`, once for
  /// each statement.
  bool FitsDepth(int height, const text::Span& span);
  /// True if this statement is nested too deeply, so that the rest of it is skipped.
  bool gave_up() const { return gave_up_; }
  void BeginStatement() { gave_up_ = false; }

  /// Parses a name that is defined here: `my_bench` after `benchmark`. Reports an invalid name and
  /// returns the one that was probably meant; nullopt if there is no name at all. `what` is for the
  /// message: `a let`. `within_value`: a `-` after the name is an operator.
  std::optional<Name> ParseName(std::string_view what, bool within_value = false);
  /// The path at the cursor, as the head of a statement; reports reserved words in it, and `-`.
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
  std::vector<int> faulty_before_;  ///< by token: the number of faulty tokens before it
  std::size_t index_ = 0;
  int error_count_ = 0;
  int depth_ = 0;
  bool gave_up_ = false;
};

/// Raises the depth by one level for its lifetime.
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
