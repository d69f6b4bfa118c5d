#include "runtime/editor/context.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>
#include <variant>

#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/scenario/layers.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/lexer.h"
#include "runtime/manual/lookup.h"

namespace cdb::editor {
namespace {

using dsl::Token;
using dsl::TokenKind;
using scenario::Joined;

class ContextFinder {
 public:
  ContextFinder(const text::Source& source, std::uint32_t offset)
      : source_(source), offset_(offset), word_begin_(WordBegin()) {}

  Context Find() {
    dsl::Diagnostics unused;
    const dsl::TokenList list = dsl::Lex(source_, unused);
    context_.begin = context_.end = offset_;
    for (const text::Span& comment : list.comments)
      if (comment.begin < offset_ && offset_ <= comment.end) return context_;
    for (const Token& token : list.tokens) {
      if (token.kind == TokenKind::kEnd || token.begin >= offset_) break;
      if (token.kind != TokenKind::kText && token.begin >= word_begin_) {
        WriteFrom(word_begin_, std::max(offset_, token.end));
        break;
      }
      if (IsBeingWritten(token)) {
        WriteFrom(token.begin, token.end);
        break;
      }
      Take(token);
    }
    if (blocks_.empty()) {
      FindInFile();
    } else {
      FindInBlock();
    }
    return context_;
  }

 private:
  struct Block {
    std::string kind, label;
  };

  std::string_view TextOf(const Token& token) const {
    return source_.text().substr(token.begin, token.end - token.begin);
  }
  bool IsBeingWritten(const Token& token) const {
    return token.kind == TokenKind::kText && (offset_ < token.end || token.faulty);
  }

  void WriteFrom(std::uint32_t begin, std::uint32_t end) {
    context_.begin = begin;
    context_.end = end;
    context_.prefix = source_.text().substr(begin, offset_ - begin);
  }

  /// The start of the name before the position. The name may end with a dot: `world.`.
  std::uint32_t WordBegin() const {
    const auto is_of_name = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
             c == '_' || c == '.';
    };
    std::uint32_t begin = offset_;
    while (begin > 0 && is_of_name(source_.text()[begin - 1])) --begin;
    return begin;
  }

  void Take(const Token& token) {
    switch (token.kind) {
      case TokenKind::kLeftBrace: {
        Block block;
        if (!statement_.empty()) block.kind = TextOf(statement_[0]);
        if (statement_.size() > 1) block.label = TextOf(statement_[1]);
        blocks_.push_back(std::move(block));
        statement_.clear();
        break;
      }
      case TokenKind::kRightBrace:
        if (!blocks_.empty()) blocks_.pop_back();
        statement_.clear();
        break;
      case TokenKind::kNewline:
      case TokenKind::kSemicolon:
        statement_.clear();
        break;
      default:
        statement_.push_back(token);
    }
  }

  std::string_view Word(std::size_t index) const {
    return index < statement_.size() ? TextOf(statement_[index]) : std::string_view();
  }

  void FindInFile() {
    if (statement_.empty()) {
      context_.expected = Expected::kItem;
    } else if (Word(0) == "let") {
      if (std::ranges::any_of(statement_, IsAssign)) context_.expected = Expected::kValue;
    } else if (Word(0) == "use") {
      context_.expected = Expected::kFile;
    } else if (Word(0) == "benchmark" && TextOf(statement_.back()) == "from") {
      context_.expected = Expected::kBase;
    }
  }
  static bool IsNamedBlock(std::string_view kind) {
    return !kind.empty() && schema::NamedBlockOf(kind) == kind;
  }
  static bool IsAssign(const Token& token) { return token.kind == TokenKind::kAssign; }

  /// A case is not a block level of its own: its statements belong to the benchmark.
  void FindPlace() {
    for (std::size_t i = 1; i < blocks_.size(); ++i) {
      const Block& block = blocks_[i];
      if (block.kind == "cases") {
        ++i;  // skip the case itself
      } else if ((block.kind == "objects" || IsNamedBlock(block.kind)) && context_.block.empty() &&
                 !context_.is_grouped) {
        context_.is_grouped = true;
        if (IsNamedBlock(block.kind)) context_.block = block.kind;
        context_.group = block.label.empty() ? block.kind : block.label;
      } else {
        context_.block = Joined(context_.block, block.kind);
      }
    }
  }

  void FindInBlock() {
    FindPlace();
    if (blocks_.back().kind == "cases") return;  // the position is at the name of a case
    if (statement_.empty()) {
      context_.expected = Expected::kStatement;
    } else if (Word(0) == "let") {
      if (std::ranges::any_of(statement_, IsAssign)) context_.expected = Expected::kValue;
    } else if (Word(0) == "skip") {
      context_.expected = Expected::kCondition;
      FindCompared();
    } else if (Word(0) != "cases" && Word(0) != "objects" && !IsNamedBlock(Word(0))) {
      context_.parameter = ParameterAt(context_, std::string(Word(0)));
      context_.expected = Expected::kValue;
    }
    FindOpenWord();
  }

  /// In `skip when detector == `, the words of `detector` are expected.
  void FindCompared() {
    for (std::size_t i = statement_.size(); i-- > 1;) {
      const TokenKind kind = statement_[i].kind;
      if (kind == TokenKind::kEqual || kind == TokenKind::kNotEqual) {
        context_.parameter = ParameterAt(context_, std::string(Word(i - 1)));
        return;
      }
      if (kind == TokenKind::kPath) return;
    }
  }

  /// Finds the word whose bracket is open: `ring(`.
  void FindOpenWord() {
    int closed = 0;
    for (std::size_t i = statement_.size(); i-- > 0;) {
      if (statement_[i].kind == TokenKind::kRightParen) ++closed;
      if (statement_[i].kind != TokenKind::kLeftParen) continue;
      if (closed-- > 0) continue;
      if (i > 0) context_.word = schema::FindParametrisedWord(Word(i - 1));
      return;
    }
  }

  const text::Source& source_;
  const std::uint32_t offset_, word_begin_;
  Context context_;
  std::vector<Block> blocks_;
  std::vector<Token> statement_;  ///< tokens of the statement up to the position
};

}  // namespace

Context ContextAt(const text::Source& source, std::uint32_t offset) {
  return ContextFinder(source, offset).Find();
}

const schema::Parameter* ParameterAt(const Context& context, const std::string& path) {
  if (const auto* found = schema::FindParameter(Joined(context.block, path), context.is_grouped))
    return found;
  if (context.is_grouped || !context.block.empty()) return nullptr;
  const std::size_t dot = path.find('.');
  const std::string own = dot == path.npos ? path : path.substr(dot + 1);
  const auto* of_group = schema::FindParameter(own, true);
  for (const std::string_view block : schema::kNamedBlocks)
    if (of_group == nullptr) of_group = schema::FindParameter(Joined(block, own), true);
  return of_group;
}

namespace {

Json LocationJson(const text::Span& span) {
  return {{"uri", UriOf(span.source->name())}, {"range", RangeJson(span)}};
}

/// The first `use` of the main file: the position for errors in used files.
text::Span FirstUse(const Analysis& analysis) {
  for (const auto& item : analysis.compilation.scenario->main()->tree.items)
    if (const auto* use = std::get_if<dsl::Use>(&item)) return use->span;
  return {&analysis.source(), 0, 0};
}

Json DiagnosticJson(const dsl::Diagnostic& diagnostic, const Analysis& analysis) {
  const bool is_here = diagnostic.span.source == &analysis.source();
  std::string message = diagnostic.message;
  if (!is_here && diagnostic.span.source != nullptr)
    message = fmt::format("{}:{}: {}", diagnostic.span.source->name(),
                          diagnostic.span.source->PositionAt(diagnostic.span.begin).line, message);
  if (!diagnostic.help.empty()) message += "\n" + diagnostic.help;
  Json related = Json::array();
  for (const dsl::Note& note : diagnostic.notes)
    if (note.span.source != nullptr)
      related.push_back({{"location", LocationJson(note.span)}, {"message", note.text}});
  const bool is_error = diagnostic.kind->severity() == dsl::Severity::kError;
  Json json = {{"range", RangeJson(is_here ? diagnostic.span : FirstUse(analysis))},
               {"severity", is_error ? 1 : 2},
               {"code", diagnostic.kind->code},
               {"source", "cdb"},
               {"message", message}};
  if (!related.empty()) json["relatedInformation"] = std::move(related);
  if (diagnostic.kind == &scenario::kUnreachable || diagnostic.kind == &scenario::kNoEffect)
    json["tags"] = {1};  // unnecessary
  return json;
}

/// The span of the name or word at the position.
std::optional<text::Span> WordAt(const text::Source& source, std::uint32_t offset) {
  dsl::Diagnostics unused;
  for (const dsl::Token& token : dsl::Lex(source, unused).tokens)
    if (token.kind == dsl::TokenKind::kPath && token.begin <= offset && offset <= token.end)
      return text::Span{&source, token.begin, token.end};
  return std::nullopt;
}

std::string RunsText(const grid::Grid& grid) {
  return fmt::format("{} {}", grid.run_count(), grid.run_count() == 1 ? "run" : "runs");
}

std::string SymbolText(const Definition& definition, const Analysis& analysis) {
  if (definition.kind == SymbolKind::kLet) return fmt::format("let {}", TextOf(definition.whole));
  std::string text(TextOf(definition.whole));
  text.erase(text.find_last_not_of(" \n") + 1);
  for (const grid::Grid& grid : analysis.compilation.grids)
    if (definition.kind == SymbolKind::kBenchmark && grid.head.benchmark == TextOf(definition.name))
      text += "\n" + RunsText(grid);
  return text;
}

}  // namespace

Json DiagnosticsOf(const Analysis& analysis) {
  constexpr std::size_t kMost = 1000;
  Json all = Json::array();
  if (analysis.compilation.scenario->main() == nullptr) return all;
  for (const dsl::Diagnostic& diagnostic : analysis.compilation.diagnostics.all())
    if (all.size() < kMost) all.push_back(DiagnosticJson(diagnostic, analysis));
  return all;
}

Json HoverAt(const Analysis& analysis, std::uint32_t offset) {
  const text::Source& source = analysis.source();
  const auto word = WordAt(source, offset);
  if (!word) return nullptr;
  const std::string name(TextOf(*word));
  std::string text;
  if (const Occurrence* symbol = analysis.symbols.At(source, offset)) {
    text = SymbolText(analysis.symbols.definitions()[symbol->definition], analysis);
  } else {
    const Context context = ContextAt(source, word->begin);
    const schema::Parameter* parameter =
        context.expected == Expected::kStatement || context.expected == Expected::kCondition
            ? ParameterAt(context, name)
            : nullptr;
    text = parameter != nullptr ? manual::ParameterReference(*parameter) : manual::TextAbout(name);
  }
  if (text.empty()) return nullptr;
  return {{"contents", {{"kind", "markdown"}, {"value", "```text\n" + text + "\n```"}}},
          {"range", RangeJson(*word)}};
}

Json DefinitionOf(const Analysis& analysis, const std::string& path, std::uint32_t offset,
                  const std::string& library) {
  const text::Source& source = analysis.source();
  if (const Occurrence* symbol = analysis.symbols.At(source, offset))
    return LocationJson(analysis.symbols.definitions()[symbol->definition].name);
  if (analysis.compilation.scenario->main() == nullptr) return nullptr;
  namespace fs = std::filesystem;
  for (const auto& item : analysis.compilation.scenario->main()->tree.items) {
    const auto* use = std::get_if<dsl::Use>(&item);
    if (use == nullptr || use->path_span.source == nullptr || offset < use->path_span.begin ||
        offset > use->path_span.end)
      continue;
    std::error_code error;
    for (const fs::path& folder : {fs::path(path).parent_path(), fs::path(library)})
      for (const char* extension : {"", ".cdb"}) {
        const fs::path file = (folder / (use->path + extension)).lexically_normal();
        if (fs::is_regular_file(file, error))
          return {{"uri", UriOf(file.string())}, {"range", RangeJson({})}};
      }
  }
  return nullptr;
}

Json ReferencesTo(const Analysis& analysis, std::uint32_t offset) {
  Json all = Json::array();
  if (const Occurrence* symbol = analysis.symbols.At(analysis.source(), offset))
    for (const text::Span& span : analysis.symbols.FamilyOf(symbol->definition))
      all.push_back(LocationJson(span));
  return all;
}

Json InlayHints(const Analysis& analysis) {
  Json hints = Json::array();
  for (const Definition& definition : analysis.symbols.definitions()) {
    if (definition.kind != SymbolKind::kBenchmark || definition.name.source != &analysis.source())
      continue;
    for (const grid::Grid& grid : analysis.compilation.grids) {
      const plan::Plan& head = grid.head;
      if (head.benchmark != TextOf(definition.name)) continue;
      std::string axes;
      for (const plan::Axis& axis : head.axes)
        axes += fmt::format("{}{} {}", axes.empty() ? "" : " x ", axis.values.size(), axis.name);
      if (head.repeats > 1)
        axes += fmt::format("{}{} rep", axes.empty() ? "" : " x ", head.repeats);
      hints.push_back({{"position", ToJson(PositionOf(analysis.source(), definition.name.end))},
                       {"label", RunsText(grid)},
                       {"tooltip", axes},
                       {"paddingLeft", true}});
      break;
    }
  }
  return hints;
}

std::optional<plan::Plan> FirstRunOf(const Analysis& analysis, const std::string& benchmark) {
  constexpr std::uint64_t kMostPoints = 1000;
  for (const grid::Grid& grid : analysis.compilation.grids)
    if (grid.head.benchmark == benchmark)
      if (plan::Plan plan = grid::ListRuns(grid, kMostPoints); !plan.runs.empty()) return plan;
  return std::nullopt;
}

Json SymbolsOf(const Analysis& analysis) {
  constexpr int kModule = 2, kVariable = 13, kObject = 19;
  Json all = Json::array();
  for (const Definition& definition : analysis.symbols.definitions()) {
    if (definition.name.source != &analysis.source()) continue;
    const int kind = definition.kind == SymbolKind::kBenchmark ? kModule
                     : definition.kind == SymbolKind::kLet     ? kVariable
                                                               : kObject;
    all.push_back({{"name", TextOf(definition.name)},
                   {"kind", kind},
                   {"range", RangeJson(Join(definition.whole, definition.name))},
                   {"selectionRange", RangeJson(definition.name)}});
  }
  return all;
}

}  // namespace cdb::editor
