// The parser of statements, blocks and the items of a file: of everything except values.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dsl/diagnostics.h"
#include "dsl/syntax.h"
#include "dsl/token_cursor.h"
#include "dsl/value_parser.h"

namespace cdb::dsl {

/// Every function reports the errors it finds, and goes on where the next statement begins.
class StatementParser {
 public:
  StatementParser(const text::Source& source, Diagnostics& diagnostics)
      : cursor_(source, diagnostics), values_(cursor_) {}

  void ParseItems(File& file);

 private:
  /// Reports a statement outside a benchmark, once for consecutive ones, and drops it. True if the
  /// end of the statement has been read too.
  bool DropOutsideBenchmark(const Token& token, bool& is_reported);
  Use ParseUse();
  /// For `let a, b = zip(…)` the first let; the others are then in `more_lets_`.
  std::optional<Let> ParseLet();
  /// The `=` of a let. False if no value follows; a missing `=` is reported.
  bool ParseEquals(const Name& name);
  /// The lets of `zip`, which has been read; empty, with a report, where they do not fit.
  std::vector<Let> Unzip(std::vector<Name> names, ExprPtr zip);
  Benchmark ParseBenchmark();
  void ParseStatement(std::vector<Statement>& statements);
  std::optional<Cases> ParseCases();
  std::optional<Case> ParseCase();
  Skip ParseSkip();
  Require ParseRequire();
  bool AtGroup() const;
  std::optional<Group> ParseGroup(Name kind, bool faulty);
  Setting ParseSetting(Name path);
  bool ParseMoreValues(Setting& setting);
  bool IsTrailing(const Token& comma, const Token& first, const Expr& value) const;
  bool RefuseSecondArgument(const Expr& value);
  bool RefuseCommaBetweenStatements(const Setting& setting, const Token& comma, std::size_t start,
                                    const Expr& value);
  bool BeginsAnotherValue(std::size_t ahead) const;
  bool RefuseUnit(const Setting& setting);
  bool RefuseWordOfRange(const Setting& setting);
  bool RefuseSecondNumber(const Setting& setting);
  bool RefuseLoop();
  /// Of `size = 5` and `size: 5`.
  void RefuseSign();
  bool RefuseMissingSemicolon(ExprKind last, const std::string& word);
  void ParseMisplaced();

  /// Parses a block and its braces. If there is none, returns false and reports it as missing from
  /// `owner`.
  bool ParseBlock(Block& block, const text::Span& owner);
  /// Calls `parse_one` for everything between the braces.
  bool ParseBraces(text::Span& span, const text::Span& owner,
                   const std::function<void()>& parse_one);
  bool ListInBraces() const;
  void SkipBraces();
  void ReportUnclosed();
  bool AtFileItem() const;

  /// Replaces the value of a statement that contains an error by an unknown value, and keeps the
  /// statement. `faults` is the number of errors before it.
  void Poison(Statement& statement, int faults);
  void Poison(Let& let);
  void AddDamage(Damage damage) { damage_ = std::max(damage_, damage); }
  /// Expects the end of a statement.
  void EndStatement();
  void ReportStrayBracket();
  /// Reports that no statement begins with `first`, and skips to the end of the statement.
  void SkipNoStatement(const Token& first);
  /// To the end of the statement; blocks on the way are still checked.
  void SkipStatement();
  void SkipEmpty() {
    while (cursor_.At(TokenKind::kNewline) || cursor_.At(TokenKind::kSemicolon)) cursor_.Take();
  }

  struct OpenBlock {
    text::Span brace;
    std::uint32_t indent;  // of the line on which the block opens
  };
  std::uint32_t IndentAt(std::uint32_t offset) const;

  TokenCursor cursor_;
  ValueParser values_;
  std::vector<OpenBlock> open_;
  // The brace of a block closed by a '}' that is indented less than expected: if a '}' is missing
  // at the end, it is the one of this block, whatever the count of braces gives.
  std::optional<text::Span> suspect_;
  std::vector<Let> more_lets_;     // of the current statement
  Damage damage_ = Damage::kNone;  // of the current benchmark, or of the file outside benchmarks
  bool unclosed_reported_ = false;
  bool statement_begins_ = false;  // after a missing end of a statement was reported
};

}  // namespace cdb::dsl
