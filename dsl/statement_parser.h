// Statements, blocks and the items of a file: all of the language but values.
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

/// Every function reports what is wrong, and goes on where the next statement begins.
class StatementParser {
 public:
  StatementParser(const text::Source& source, Diagnostics& diagnostics)
      : cursor_(source, diagnostics), values_(cursor_) {}

  void ParseItems(File& file);

 private:
  /// A statement outside a benchmark is reported, one of a row of them, and dropped. True if the
  /// end of the statement has been read as well.
  bool DropOutsideBenchmark(const Token& token, bool& is_reported);
  Use ParseUse();
  /// Of `let a, b = zip(…)` the first; the others are then in `more_lets_`.
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
  bool AtGroup() const;
  std::optional<Group> ParseGroup(Name kind, bool faulty);
  Setting ParseSetting(Name path);
  bool ParseMoreValues(Setting& setting);
  bool IsTrailing(const Token& comma, const Token& first, const Expr& value) const;
  bool RefuseSecondArgument(const Expr& value);
  bool RefuseCommaBetweenStatements(const Setting& setting, const Token& comma, std::size_t start,
                                    const Expr& value);
  bool RefuseUnit(ExprKind last);
  bool RefuseSecondNumber(const Setting& setting);
  bool RefuseLoop();
  /// Of `size = 5` and `size: 5`.
  void RefuseSign();
  bool RefuseMissingSemicolon(ExprKind last, const std::string& word);
  void ParseMisplaced();

  /// A block and its braces. False where there is none, which is reported as missing from `owner`.
  bool ParseBlock(Block& block, const text::Span& owner);
  /// Calls `parse_one` for everything between the braces.
  bool ParseBraces(text::Span& span, const text::Span& owner,
                   const std::function<void()>& parse_one);
  bool ListInBraces() const;
  void SkipBraces();
  void ReportUnclosed();
  bool AtFileItem() const;

  /// What follows an error in a statement that began with `faults` of them: the statement stays,
  /// with a value that nothing is known of.
  void Poison(Statement& statement, int faults);
  void Poison(Let& let);
  void AddDamage(Damage damage) { damage_ = std::max(damage_, damage); }
  /// After a statement: its end has to be here.
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
    std::uint32_t indent;  // of the line on which it opens
  };
  std::uint32_t IndentAt(std::uint32_t offset) const;

  TokenCursor cursor_;
  ValueParser values_;
  std::vector<OpenBlock> open_;
  // The brace of a block that was closed by a '}' further left than it should be: where a '}' is
  // missing at the end, it is this block's, whatever the count says.
  std::optional<text::Span> suspect_;
  std::vector<Let> more_lets_;     // of the present statement
  Damage damage_ = Damage::kNone;  // of the present benchmark, or of the file outside of them
  bool unclosed_reported_ = false;
  bool statement_begins_ = false;  // where a statement's end is missing and was reported
};

}  // namespace cdb::dsl
