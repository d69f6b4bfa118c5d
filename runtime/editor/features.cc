#include "runtime/editor/features.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>
#include <variant>

#include "compiler/scenario/diagnostic_kinds.h"
#include "dsl/lexer.h"
#include "runtime/editor/context.h"
#include "runtime/manual/lookup.h"
#include "runtime/manual/word.h"

namespace cdb::editor {
namespace {

std::string_view TextOf(const text::Span& span) {
  return span.source->text().substr(span.begin, span.end - span.begin);
}

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
  if (diagnostic.kind == &scenario::kUnreachable) json["tags"] = {1};  // unnecessary
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
