#include "dsl/parser.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dsl/diagnostics.h"
#include "dsl/statement_parser.h"
#include "dsl/text/concat.h"

namespace cdb::dsl {

void StatementParser::ParseItems(File& file) {
  bool misplaced_reported = false;
  while (true) {
    SkipEmpty();
    open_.clear();
    suspect_.reset();
    unclosed_reported_ = false;
    cursor_.BeginStatement();
    const Token token = cursor_.Peek();
    const int faults = cursor_.fault_count();
    if (token.kind == TokenKind::kEnd) break;
    if (cursor_.AtWord("use")) {
      file.items.emplace_back(ParseUse());
      if (cursor_.fault_count() > faults) AddDamage(Damage::kLost);
    } else if (cursor_.AtWord("let")) {
      if (std::optional<Let> let = ParseLet())
        file.items.emplace_back(std::move(*let));
      else
        AddDamage(Damage::kLost);
    } else if (cursor_.AtWord("benchmark")) {
      misplaced_reported = false;
      file.items.emplace_back(ParseBenchmark());
    } else if (token.kind == TokenKind::kRightBrace) {
      AddDamage(Damage::kLost);
      cursor_.Report(kStrayBrace, cursor_.SpanOf(token), "this '}' does not close any block");
      cursor_.Take();
      continue;
    } else if (token.kind == TokenKind::kPath) {
      AddDamage(Damage::kLost);
      if (DropOutsideBenchmark(token, misplaced_reported)) continue;
    } else {
      AddDamage(Damage::kLost);
      cursor_.ReportUnexpected("use, let or benchmark");
      SkipStatement();
    }
    EndStatement();
    auto* let = file.items.empty() ? nullptr : std::get_if<Let>(&file.items.back());
    const bool is_this = let != nullptr && token.begin < let->name.span.begin;
    if (is_this && (cursor_.fault_count() > faults || !let->value)) Poison(*let);
    for (Let& more : std::exchange(more_lets_, {})) {
      if (cursor_.fault_count() > faults) Poison(more);
      file.items.emplace_back(std::move(more));
    }
  }
  file.damage = damage_;
}

bool StatementParser::DropOutsideBenchmark(const Token& token, bool& is_reported) {
  const std::string_view meant = DidYouMean(cursor_.Text(token), {"benchmark", "use", "let"});
  if ((!is_reported || !meant.empty()) && !token.faulty)
    cursor_.Report(kMisplacedStatement, cursor_.SpanOf(token),
                   cursor_.Quote(token) + " is not allowed outside a benchmark",
                   meant.empty() ? "a file consists of use, let and benchmark NAME { … }"
                                 : text::Concat({"did you mean '", meant, "'?"}));
  is_reported |= meant.empty();
  if (meant.empty()) {
    std::vector<Statement> dropped;
    ParseStatement(dropped);
    return true;
  }
  if (meant == "benchmark")
    ParseBenchmark();
  else
    SkipStatement();
  return false;
}

Use StatementParser::ParseUse() {
  const Token word = cursor_.Take();
  Use use;
  if (cursor_.AtWord("detector")) {
    cursor_.Take();
    use.detector = true;
  }
  if (cursor_.At(TokenKind::kText)) {
    const Token text = cursor_.Take();
    use.path = TextContents(cursor_.Text(text));
    use.path_span = cursor_.SpanOf(text);
  } else if (cursor_.AtStatementEnd()) {
    cursor_.Report(
        kMissingValue, cursor_.SpanOf(cursor_.Previous()),
        cursor_.Quote(cursor_.Previous()) + " needs a file's name after it",
        use.detector ? "for example: use detector \"mine.so\"" : "for example: use \"base.cdb\"");
  } else {
    // A bare file name becomes many tokens, but is one word to the user.
    const std::uint32_t begin = cursor_.Peek().begin;
    const bool faulty = cursor_.Peek().faulty;
    while (!cursor_.AtStatementEnd() && !cursor_.At(TokenKind::kLeftBrace)) cursor_.Take();
    if (!faulty && cursor_.Previous().end > begin) {
      const text::Span span = cursor_.SpanFrom(begin);
      cursor_.Report(
          kMissingQuotes, span, "the name of a file is written in quotes",
          text::Concat({"write \"",
                        cursor_.source().text().substr(span.begin, span.end - span.begin), "\""}));
    }
  }
  use.span = cursor_.SpanFrom(word.begin);
  return use;
}

std::optional<Let> StatementParser::ParseLet() {
  const Token word = cursor_.Take();
  std::optional<Name> name = cursor_.ParseName("a let");
  if (!name) {
    if (!cursor_.Peek().faulty)
      cursor_.Report(kMissingName, cursor_.SpanOf(word), "'let' needs a name after it",
                     "for example: let n = sweep(10, 100)");
    SkipStatement();
    return std::nullopt;
  }
  std::vector<Name> names = {*name};
  while (cursor_.At(TokenKind::kComma) && cursor_.Peek(1).kind == TokenKind::kPath) {
    cursor_.Take();
    if (std::optional<Name> next = cursor_.ParseName("a let")) names.push_back(std::move(*next));
  }
  if (cursor_.At(TokenKind::kLeftParen)) {
    cursor_.Report(kNoFunctions, cursor_.SpanOf(cursor_.Peek()),
                   "a let is a value and cannot take arguments",
                   text::Concat({"write: let ", name->text, " = …"}));
    SkipStatement();
    return Let{std::move(*name), nullptr};
  }
  if (!ParseEquals(*name)) return Let{std::move(*name), nullptr};
  ExprPtr value = values_.ParseValue();
  if (!value) {
    SkipStatement();
  } else if (cursor_.At(TokenKind::kComma)) {
    const bool begins_let =
        cursor_.Peek(1).kind == TokenKind::kPath && cursor_.Peek(2).kind == TokenKind::kAssign;
    cursor_.Report(kOneValue, cursor_.SpanOf(cursor_.Peek()), "a let holds one value",
                   begins_let ? text::Concat({"write ';' and another let: let ",
                                              cursor_.Text(cursor_.Peek(1)), " = …"})
                              : std::string("to vary it, write sweep(a, b)"));
    SkipStatement();
  }
  if (names.size() == 1) return Let{std::move(*name), std::move(value)};
  more_lets_ = Unzip(names, std::move(value));
  // After an error, the names are known but their values are not.
  if (more_lets_.empty())
    for (Name& one : names) more_lets_.push_back({std::move(one), nullptr});
  Let first = std::move(more_lets_.front());
  more_lets_.erase(more_lets_.begin());
  return first;
}

bool StatementParser::ParseEquals(const Name& name) {
  const std::string help = text::Concat({"write: let ", name.text, " = …"});
  if (cursor_.At(TokenKind::kAssign)) {
    cursor_.Take();
    return true;
  }
  if (cursor_.AtStatementEnd()) {
    cursor_.Report(kMissingEquals, name.span, "this name has no value", help);
    return false;
  }
  const Token& found = cursor_.Peek();
  const bool instead = found.kind == TokenKind::kColon || found.kind == TokenKind::kEqual;
  if (!found.faulty)
    cursor_.Report(kMissingEquals, cursor_.SpanOf(found),
                   text::Concat({"expected '=' before the value, not ", cursor_.Describe(found)}),
                   help);
  if (instead) cursor_.Take();
  return true;
}

std::vector<Let> StatementParser::Unzip(std::vector<Name> names, ExprPtr zip) {
  if (!zip) return {};
  const auto fail = [this](const text::Span& span, std::string_view message,
                           std::string_view help) {
    cursor_.Report(kOneValue, span, std::string(message), std::string(help));
    return std::vector<Let>();
  };
  constexpr std::string_view kForm = "write: let a, b = zip(sweep(1, 2), sweep(10, 20))";
  if (zip->kind != ExprKind::kCall || zip->text != "zip")
    return fail(zip->span, "several names need a zip() of several sweeps", kForm);
  if (zip->arguments.size() != names.size())
    return fail(zip->span,
                text::Concat({"here are ", std::to_string(names.size()), " names, but zip() has ",
                              std::to_string(zip->arguments.size()), " sweeps"}),
                "each name is one of the sweeps");
  auto all = std::make_shared<Zip>();
  all->span = zip->span;
  all->names = names;
  all->axis = zip->axis;
  all->axis_title = zip->axis_title;
  for (const Argument& argument : zip->arguments) {
    const Expr& value = *argument.value;
    if (argument.name || argument.weight || value.kind != ExprKind::kCall || value.text != "sweep")
      return fail(value.span, "zip() takes only sweeps", kForm);
    if (value.axis)
      return fail(value.axis->span, "the sweeps of zip() make one axis, which has one name",
                  text::Concat({"write it after zip(): zip(…) as ", value.axis->text}));
    if (!value.axis_title.empty())
      return fail(value.span, "the sweeps of zip() make one axis, which has one title",
                  text::Concat({"write it after zip(): zip(…) as \"", value.axis_title, "\""}));
    all->sweeps.push_back(&value);
  }
  std::vector<Let> lets;
  for (std::size_t i = 0; i < names.size(); ++i) {
    ExprPtr sweep = std::move(zip->arguments[i].value);
    sweep->zip = all;
    lets.push_back({std::move(names[i]), std::move(sweep)});
  }
  return lets;
}

Benchmark StatementParser::ParseBenchmark() {
  const Token word = cursor_.Take();
  const Damage outside = std::exchange(damage_, Damage::kNone);
  Benchmark benchmark;
  std::optional<Name> name;
  if (!cursor_.AtWord("from") || cursor_.Peek(1).kind != TokenKind::kPath)
    name = cursor_.ParseName("a benchmark");
  if (name) {
    benchmark.name = std::move(*name);
  } else if (!cursor_.Peek().faulty || cursor_.At(TokenKind::kText)) {
    cursor_.Report(kMissingName, cursor_.SpanOf(word), "'benchmark' needs a name after it",
                   "for example: benchmark aspect \"what it asks\" { … }");
  }
  bool titled = false;
  while (cursor_.AtWord("from") || (cursor_.At(TokenKind::kText) && !titled)) {
    const Token token = cursor_.Take();
    if (token.kind == TokenKind::kText) {
      benchmark.title = TextContents(cursor_.Text(token));
      titled = true;
      continue;
    }
    if (titled || benchmark.from)
      cursor_.Report(
          kMisplacedFrom, cursor_.SpanOf(token),
          titled ? "'from' must precede the title" : "a benchmark has at most one 'from'",
          "write: benchmark NAME from OTHER \"title\" { … }");
    benchmark.from = cursor_.ParseName("a benchmark");
    if (!benchmark.from && !cursor_.Peek().faulty)
      cursor_.Report(kMissingName, cursor_.SpanOf(token),
                     "'from' needs the name of a benchmark after it");
  }
  const text::Span owner = cursor_.SpanFrom(word.begin);
  if (!ParseBlock(benchmark.block, owner)) {
    benchmark.block.span = owner;
    AddDamage(Damage::kMisnested);
  }
  benchmark.damage = std::exchange(damage_, outside);
  benchmark.span = cursor_.SpanFrom(word.begin);
  return benchmark;
}

File Parse(std::shared_ptr<const text::Source> source, Diagnostics& diagnostics) {
  File file;
  file.source = std::move(source);
  StatementParser(*file.source, diagnostics).ParseItems(file);
  return file;
}

}  // namespace cdb::dsl
