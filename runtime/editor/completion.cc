#include "runtime/editor/completion.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>
#include <system_error>

#include "compiler/schema/language_words.h"
#include "dsl/lexer.h"
#include "runtime/editor/context.h"
#include "runtime/manual/lookup.h"

namespace cdb::editor {
namespace {

namespace fs = std::filesystem;
using schema::Parameter;

/// CompletionItemKind of the protocol.
enum class ItemKind {
  kFunction = 3,
  kVariable = 6,
  kModule = 9,
  kProperty = 10,
  kKeyword = 14,
  kFile = 17,
  kReference = 18,
  kEnumMember = 20
};

class Completer {
 public:
  Completer(const Analysis& analysis, const std::string& path, std::uint32_t offset,
            const std::string& library)
      : analysis_(analysis),
        path_(path),
        library_(library),
        context_(ContextAt(analysis.source(), offset)),
        range_(RangeJson({&analysis.source(), context_.begin, context_.end})) {}

  Json Run() {
    switch (context_.expected) {
      case Expected::kNothing:
        break;
      case Expected::kItem:
        for (const char* word : {"benchmark", "let", "use"}) AddWord(word, ItemKind::kKeyword);
        break;
      case Expected::kStatement:
        AddStatements();
        break;
      case Expected::kValue:
        AddValues();
        break;
      case Expected::kCondition:
        AddCondition();
        break;
      case Expected::kBase:
        AddNames(SymbolKind::kBenchmark, ItemKind::kReference, "benchmark");
        break;
      case Expected::kFile:
        AddFiles();
        break;
    }
    return std::move(items_);
  }

 private:
  void Add(const std::string& label, ItemKind kind, std::string_view detail) {
    if (label.empty() || !seen_.insert(label).second) return;
    items_.push_back({{"label", label},
                      {"kind", static_cast<int>(kind)},
                      {"detail", detail},
                      {"textEdit", {{"range", range_}, {"newText", label}}}});
  }
  void AddWord(std::string_view word, ItemKind kind) {
    Add(std::string(word), kind, manual::LineAbout(word));
  }

  void AddNames(SymbolKind kind, ItemKind item, std::string_view detail) {
    for (const Definition& definition : analysis_.symbols.definitions()) {
      const text::Span& span = definition.name;
      if (definition.kind == kind && span.source != nullptr)
        Add(std::string(span.source->text().substr(span.begin, span.end - span.begin)), item,
            detail);
    }
  }

  /// The names of parameters and blocks that may begin a statement here.
  void AddStatements() {
    const std::string prefix = context_.block.empty() ? "" : context_.block + ".";
    for (const Parameter& parameter : schema::Schema())
      if (parameter.grouped == context_.is_grouped && parameter.name.starts_with(prefix))
        Add(std::string(parameter.name.substr(prefix.size())), ItemKind::kProperty, parameter.doc);
    for (const std::string_view block : schema::BlocksIn(context_.block, context_.is_grouped))
      Add(std::string(block), ItemKind::kModule, "a block");
    AddWord("let", ItemKind::kKeyword);
    if (context_.is_grouped || !context_.block.empty()) return;
    for (const char* word : {"objects", "cases", "skip"}) AddWord(word, ItemKind::kKeyword);
    for (const Parameter& parameter : schema::Schema())
      if (parameter.grouped) Add(parameter.FullName(), ItemKind::kProperty, parameter.doc);
  }

  void AddWordsOf(const Parameter& parameter) {
    for (const std::string_view word :
         parameter.AllWords(analysis_.compilation.scenario->plugins()))
      AddWord(word, ItemKind::kEnumMember);
    for (const std::string_view call : parameter.AllCalls()) AddWord(call, ItemKind::kFunction);
    if (parameter.type == schema::ParameterType::kSwitch)
      for (const char* word : {"on", "off"}) AddWord(word, ItemKind::kEnumMember);
  }

  void AddFunctions() {
    for (const schema::LanguageWord& word : schema::LanguageWords()) {
      const bool is_drawn = word.role == schema::WordRole::kFunction && word.name != "sweep";
      const bool fits = context_.parameter == nullptr || context_.parameter->distribution;
      if (word.name == "sweep" || (is_drawn && fits)) AddWord(word.name, ItemKind::kFunction);
    }
  }

  void AddValues() {
    if (context_.word != nullptr)
      for (const Parameter& argument : context_.word->arguments) {
        Add(std::string(argument.name) + ":", ItemKind::kProperty, argument.doc);
        AddWordsOf(argument);
      }
    if (context_.parameter != nullptr) {
      AddWordsOf(*context_.parameter);
    } else {
      for (const schema::ParametrisedWord& word : schema::ParametrisedWords())
        AddWord(word.name, ItemKind::kFunction);
    }
    AddFunctions();
    AddNames(SymbolKind::kLet, ItemKind::kVariable, "let");
  }

  void AddCondition() {
    if (context_.parameter != nullptr) AddWordsOf(*context_.parameter);
    for (const char* word : {"when", "and", "or", "not"}) AddWord(word, ItemKind::kKeyword);
    AddNames(SymbolKind::kLet, ItemKind::kVariable, "let");
    for (const Parameter& parameter : schema::Schema())
      Add(std::string(parameter.name), ItemKind::kProperty, parameter.doc);
  }

  /// Scenario files beside this one and in the library, in the form that `use` takes.
  void AddFiles() {
    Add("detector", ItemKind::kKeyword, "the detectors of a shared library");
    AddFilesIn(fs::path(path_).parent_path(), 1);
    if (!library_.empty()) AddFilesIn(library_, 2);
  }

  void AddFilesIn(const fs::path& folder, int levels) {
    std::error_code error;
    std::vector<std::string> names;
    fs::recursive_directory_iterator entry(folder, error), end;
    for (; !error && entry != end; entry.increment(error)) {
      if (entry.depth() + 1 >= levels) entry.disable_recursion_pending();
      if (entry->path().extension() == ".cdb" && entry->path() != path_)
        names.push_back(fs::path(entry->path().lexically_relative(folder))
                            .replace_extension()
                            .generic_string());
    }
    std::ranges::sort(names);
    for (const std::string& name : names) Add('"' + name + '"', ItemKind::kFile, "a scenario");
  }

  const Analysis& analysis_;
  const std::string& path_;
  const std::string& library_;
  const Context context_;
  const Json range_;
  Json items_ = Json::array();
  std::set<std::string> seen_;
};

}  // namespace

Json Complete(const Analysis& analysis, const std::string& path, std::uint32_t offset,
              const std::string& library) {
  return Completer(analysis, path, offset, library).Run();
}

}  // namespace cdb::editor
