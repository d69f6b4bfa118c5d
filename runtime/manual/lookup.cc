#include "runtime/manual/lookup.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <span>
#include <string_view>
#include <vector>

#include "compiler/plan/foreign_model.h"
#include "compiler/schema/catalogue.h"
#include "compiler/schema/components.h"
#include "compiler/schema/language_words.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "runtime/manual/explanation.h"
#include "runtime/protocol/series.h"
#include "runtime/protocol/verdict.h"
#include "runtime/terminal/console.h"
#include "runtime/terminal/table.h"

namespace cdb::manual {
namespace {

using schema::Parameter;

/// A word without arguments, from one of the catalogues.
struct CatalogueWord {
  std::string kind, name, doc;
};

void AddDetectors(std::vector<CatalogueWord>& words) {
  for (const schema::DetectorInfo& detector : schema::Detectors()) {
    std::string doc(detector.doc);
    if (!detector.source.empty()) doc += fmt::format("; from {}", detector.source);
    if (detector.max_bodies > 0) doc += fmt::format("; at most {} bodies", detector.max_bodies);
    if (!detector.limits.empty()) doc += fmt::format("; {}", detector.limits);
    words.push_back({"detector", std::string(detector.name), doc});
  }
}

const std::vector<CatalogueWord>& CatalogueWords() {
  static const std::vector<CatalogueWord> all = [] {
    std::vector<CatalogueWord> words;
    const auto add = [&](const char* kind, const auto& rows) {
      for (const auto& row : rows)
        words.push_back({kind, std::string(row.name), std::string(row.doc)});
    };
    add("object type", schema::ObjectTypes());
    AddDetectors(words);
    add("layout", schema::Layouts());
    add("closed form", schema::ClosedForms());
    add("component, for omit", schema::Components());
    add("error, of the results", schema::Errors());
    add("verdict", protocol::Verdicts());
    add("series, of the results", protocol::AllSeries());
    return words;
  }();
  return all;
}

/// True if `name` is the parameter's name, its last part, or that of a block around it.
bool Names(std::string_view name, const Parameter& parameter) {
  return name == parameter.FullName() || name == parameter.name ||
         name == parameter.name.substr(parameter.name.find('.') + 1) ||
         ("." + std::string(parameter.name)).find("." + std::string(name) + ".") !=
             std::string::npos;
}

std::string LanguageWordText(const schema::LanguageWord& word) {
  static constexpr std::string_view kRoles[] = {"statement", "function", "within a statement",
                                                "value"};
  return fmt::format("{} ({})\n{}  syntax   {}\n  example  {}\n  more     cdb doc language\n",
                     word.name, kRoles[static_cast<std::size_t>(word.role)],
                     terminal::Wrapped(word.doc, 2), word.syntax, word.example);
}

/// `walls: a word of omit, world.walls`, and a description of these; empty if no parameter takes
/// it.
std::string TakersText(std::string_view name) {
  std::vector<std::string> takers;
  std::string about;
  for (const Parameter& parameter : schema::Schema()) {
    if (!parameter.HasWord(name)) continue;
    takers.push_back(parameter.FullName());
    about += "\n" + ParameterReference(parameter);
  }
  if (takers.empty()) return {};
  return terminal::Wrapped(fmt::format("{}: a word of {}", name, fmt::join(takers, ", ")), 0) +
         about;
}

std::string DiagnosticText(const Explanation& row) {
  return fmt::format("{} ({}): `cdb explain {}` explains it\n", row.kind->id, row.kind->code,
                     row.kind->code);
}

}  // namespace

std::string TextAbout(std::string_view name) {
  std::string text;
  const auto add = [&text](const std::string& part) {
    if (!part.empty()) text += (text.empty() ? "" : "\n") + part;
  };
  if (const schema::LanguageWord* word = schema::FindLanguageWord(name))
    add(LanguageWordText(*word));
  for (const Parameter& parameter : schema::Schema())
    if (Names(name, parameter)) add(ParameterReference(parameter));
  for (const schema::ParametrisedWord& word : schema::ParametrisedWords())
    if (name == word.name) add(WordReference(word));
  for (const CatalogueWord& word : CatalogueWords())
    if (name == word.name)
      add(fmt::format("{} ({})\n{}", word.name, word.kind, terminal::Wrapped(word.doc, 2)));
  add(TakersText(name));
  for (const Explanation* row : FindExplanations(name)) add(DiagnosticText(*row));
  return text;
}

std::string LineAbout(std::string_view name) {
  if (const schema::ParametrisedWord* word = schema::FindParametrisedWord(name))
    return std::string(word->doc);
  for (const CatalogueWord& word : CatalogueWords())
    if (name == word.name) return fmt::format("{}: {}", word.kind, word.doc);
  if (const schema::LanguageWord* word = schema::FindLanguageWord(name))
    return std::string(word->doc);
  return {};
}

std::vector<std::string> KnownNames() {
  std::set<std::string> names;
  for (const schema::LanguageWord& word : schema::LanguageWords()) names.emplace(word.name);
  for (const Parameter& parameter : schema::Schema()) {
    names.insert(parameter.FullName());
    names.emplace(parameter.name);
    for (const std::string_view word : parameter.AllWords()) names.emplace(word);
    for (std::size_t dot = parameter.name.find('.'); dot != parameter.name.npos;
         dot = parameter.name.find('.', dot + 1)) {
      const std::string_view block = parameter.name.substr(0, dot);
      names.emplace(block);
      names.emplace(block.substr(block.rfind('.') + 1));  // npos + 1 is 0
    }
  }
  for (const schema::ParametrisedWord& word : schema::ParametrisedWords()) names.emplace(word.name);
  for (const CatalogueWord& word : CatalogueWords()) names.insert(word.name);
  for (const Explanation* row : AllExplanations()) names.emplace(row->kind->id);
  return {names.begin(), names.end()};
}

namespace {

using schema::ParametrisedWord;

/// `stack(height: all, gap: fit, spacing: fit)`, `at(x, y, z)`.
std::string Signature(const ParametrisedWord& info) {
  std::string text = info.takes_parts ? "part(…), …" : "";
  for (const Parameter& argument : info.arguments) {
    if (!text.empty()) text += ", ";
    text += argument.name;
    if (!argument.DefaultText().empty()) text += fmt::format(": {}", argument.DefaultText());
  }
  return fmt::format("{}({})", info.name, text);
}

/// A table of every argument.
std::string Arguments(const std::vector<const ParametrisedWord*>& calls) {
  terminal::Table table;
  table.KeepWhole();
  for (const char* head : {"argument", "of", "takes", "unit", ""}) table.AddColumn(head, false);
  for (const ParametrisedWord* info : calls)
    for (const Parameter& argument : info->arguments)
      table.AddRow({std::string(argument.name), std::string(info->name), argument.Takes(),
                    std::string(argument.unit), std::string(argument.doc)});
  return table.Text();
}

std::vector<const ParametrisedWord*> CallsOf(const Parameter& parameter) {
  std::vector<const ParametrisedWord*> calls;
  for (const std::string_view name : parameter.AllCalls())
    calls.push_back(schema::FindParametrisedWord(name));
  return calls;
}

/// Words with and without arguments, then the arguments.
template <typename Rows>
std::string Words(const char* title, const Rows& rows,
                  const std::vector<const ParametrisedWord*>& calls) {
  terminal::Table table;
  table.KeepWhole();
  table.AddColumn(title, false);
  table.AddColumn("", false);
  for (const auto& row : rows) table.AddRow({std::string(row.name), std::string(row.doc)});
  for (const ParametrisedWord* info : calls)
    table.AddRow({Signature(*info), std::string(info->doc)});
  return table.Text() + "\n" + Arguments(calls);
}

std::string Words(const char* title, const std::vector<const ParametrisedWord*>& calls) {
  return Words(title, std::span<const schema::LayoutInfo>(), calls);
}

}  // namespace

std::string ParameterReference(const Parameter& parameter) {
  std::string text = fmt::format("{}\n  {}\n", parameter.FullName(), parameter.doc);
  text += fmt::format("  takes    {}\n", parameter.Takes());
  text += fmt::format("  default  {}\n", parameter.DefaultText());
  if (!parameter.unit.empty()) text += fmt::format("  unit     {}\n", parameter.UnitText());
  const auto calls = CallsOf(parameter);
  return calls.empty() ? text : text + "\n" + Words("with arguments", calls);
}

std::string WordReference(const ParametrisedWord& word) { return Words("word", {&word}); }

std::string ObjectReference() {
  const std::string_view importer = plan::ImporterOf(".dae");
  return Words("objects", schema::ObjectTypes(), CallsOf(*schema::GroupParameter("type"))) +
         fmt::format("\nMeshes of other programs (COLLADA, glTF, FBX, 3MF and so on): {}\n",
                     importer.empty() ? "not in this build: install libassimp-dev and run ./setup "
                                        "again, or ./setup --import"
                                      : fmt::format("read by {}", importer));
}

std::string LayoutReference() {
  return Words("layouts", schema::Layouts(), CallsOf(*schema::GroupParameter("location")));
}

std::string ScheduleReference() {
  return Words("schedules", CallsOf(*schema::GroupParameter("force")));
}

}  // namespace cdb::manual
