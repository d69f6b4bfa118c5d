#include "runtime/editor/rename.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

namespace cdb::editor {
namespace {

struct Edit {
  text::Span span;
  std::string path;
};

const Occurrence& LetAt(const Analysis& analysis, std::uint32_t offset) {
  const Occurrence* symbol = analysis.symbols.At(analysis.source(), offset);
  if (symbol == nullptr ||
      analysis.symbols.definitions()[symbol->definition].kind != SymbolKind::kLet)
    throw RenameError("only a let can be renamed: place the cursor on its name");
  return *symbol;
}

void CheckName(const std::string& name) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  const bool is_good =
      !name.empty() && is_letter(name[0]) &&
      std::ranges::all_of(name, [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
  if (!is_good)
    throw RenameError(
        fmt::format("'{}' cannot be a name: names are made of letters, digits and '_'", name));
}

/// Identifies the runs, independent of the names of axes. For a large grid: their number and the
/// first ones.
std::vector<std::string> RunIds(const compiler::Compilation& compilation) {
  constexpr std::uint64_t kMostPoints = 1000;
  std::vector<std::string> ids;
  for (const grid::Grid& grid : compilation.grids) {
    ids.push_back(fmt::format("{} {}", grid.head.benchmark, grid.run_count()));
    for (const plan::Run& run : grid::ListRuns(grid, kMostPoints).runs) ids.push_back(run.id);
  }
  return ids;
}

std::vector<Edit> EditsOf(const Analysis& analysis, std::size_t definition,
                          const std::string& library) {
  std::vector<Edit> edits;
  for (const text::Span& span : analysis.symbols.FamilyOf(definition)) {
    const std::string& path = span.source->name();
    if (!library.empty() && path.starts_with(library + "/"))
      throw RenameError(fmt::format("{} comes with cdb and cannot be changed", path));
    edits.push_back({span, path});
  }
  std::ranges::sort(edits, {},
                    [](const Edit& edit) { return std::pair(edit.path, edit.span.begin); });
  return edits;
}

/// The text of each file after the edits.
std::map<std::string, std::string> Edited(const std::vector<Edit>& edits, const std::string& name) {
  std::map<std::string, std::string> texts;
  for (auto edit = edits.rbegin(); edit != edits.rend(); ++edit) {
    const auto [text, is_new] = texts.try_emplace(edit->path, edit->span.source->text());
    text->second.replace(edit->span.begin, edit->span.end - edit->span.begin, name);
  }
  return texts;
}

void CheckMeaning(const compiler::Compilation& before, const compiler::Compilation& after,
                  const std::string& name) {
  const bool is_same = before.diagnostics.error_count() == after.diagnostics.error_count() &&
                       RunIds(before) == RunIds(after);
  if (!is_same)
    throw RenameError(fmt::format("'{}' has another meaning here: the runs would change", name));
}

}  // namespace

Json PrepareRename(const Analysis& analysis, std::uint32_t offset) {
  return RangeJson(LetAt(analysis, offset).span);
}

Json Rename(Documents& documents, Document& document, std::uint32_t offset, const std::string& name,
            const std::string& library) {
  CheckName(name);
  const std::shared_ptr<const Analysis> analysis = documents.Analyse(document);
  const std::vector<Edit> edits = EditsOf(*analysis, LetAt(*analysis, offset).definition, library);
  const auto texts = Edited(edits, name);
  CheckMeaning(analysis->compilation, documents.CompileWith(document.path, texts), name);
  // Texts that use this one, as far as they are open.
  for (auto& [uri, other] : documents.all())
    if (&other != &document)
      CheckMeaning(documents.Analyse(other)->compilation, documents.CompileWith(other.path, texts),
                   name);
  Json changes = Json::object();
  for (const Edit& edit : edits) {
    std::string uri = UriOf(edit.path);
    for (const auto& [open, other] : documents.all())
      if (other.path == edit.path) uri = open;
    changes[uri].push_back({{"range", RangeJson(edit.span)}, {"newText", name}});
  }
  return {{"changes", std::move(changes)}};
}

}  // namespace cdb::editor
