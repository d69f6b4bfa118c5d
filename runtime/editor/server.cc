#include "runtime/editor/server.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "compiler/evaluate/sweeps.h"
#include "compiler/schema/language_words.h"
#include "dsl/format.h"
#include "dsl/lexer.h"
#include "dsl/parser.h"
#include "runtime/editor/context.h"
#include "runtime/manual/lookup.h"

namespace cdb::editor {
namespace {

// Error codes of the protocol.
constexpr int kParseError = -32700;
constexpr int kInvalidRequest = -32600;
constexpr int kMethodNotFound = -32601;
constexpr int kInvalidParams = -32602;
constexpr int kInternalError = -32603;
constexpr int kNotInitialized = -32002;
constexpr int kRequestFailed = -32803;

bool IsId(const Json& id) { return id.is_string() || id.is_number_integer(); }

}  // namespace

Server::Server(ServerOptions options)
    : options_(std::move(options)), documents_(options_.compile) {}

void Server::Send(const Json& message) {
  options_.send(message.dump(-1, ' ', false, Json::error_handler_t::replace));
}

void Server::SendError(const Json& id, const Failure& failure) {
  Send({{"jsonrpc", "2.0"},
        {"id", id},
        {"error", {{"code", failure.code}, {"message", failure.message}}}});
}

void Server::Handle(const std::string& message) {
  const Json json = Json::parse(message, nullptr, false);
  if (json.is_discarded()) return SendError(nullptr, {kParseError, "the message is not JSON"});
  const Json& id = Member(json, "id");
  const std::string method = TextIn(json, "method");
  if (method.empty()) {
    // Answers are ignored: this server sends no requests.
    const bool is_answer = json.is_object() && (json.contains("result") || json.contains("error"));
    if (!is_answer)
      SendError(IsId(id) ? id : Json(nullptr), {kInvalidRequest, "the message has no method"});
    return;
  }
  if (!json.contains("id")) return Notification(method, Member(json, "params"));
  if (!IsId(id))
    return SendError(nullptr, {kInvalidRequest, "the id is neither a text nor a whole number"});
  Request(id, method, Member(json, "params"));
}

void Server::Request(const Json& id, const std::string& method, const Json& params) {
  try {
    if (is_shut_down_) throw Failure{kInvalidRequest, "the server has been shut down"};
    if (!is_initialized_ && method != "initialize")
      throw Failure{kNotInitialized, "`initialize` must come first"};
    Send({{"jsonrpc", "2.0"}, {"id", id}, {"result", Answer(method, params)}});
  } catch (const Failure& failure) {
    SendError(id, failure);
  } catch (const RenameError& error) {
    SendError(id, {kRequestFailed, error.what()});
  } catch (const std::exception& error) {
    SendError(id, {kInternalError, error.what()});
  }
}

void Server::Notification(const std::string& method, const Json& params) {
  const Json& document = Member(params, "textDocument");
  if (method == "exit") {
    has_ended_ = true;
  } else if (!is_initialized_ || is_shut_down_) {
    return;
  } else if (method == "textDocument/didOpen") {
    documents_.Open(document);
  } else if (method == "textDocument/didChange") {
    documents_.Change(TextIn(document, "uri"), NumberIn(document, "version"),
                      Member(params, "contentChanges"));
  } else if (method == "textDocument/didClose") {
    const std::string uri = TextIn(document, "uri");
    if (documents_.Find(uri) == nullptr) return;
    documents_.Close(uri);
    Send({{"jsonrpc", "2.0"},
          {"method", "textDocument/publishDiagnostics"},
          {"params", {{"uri", uri}, {"diagnostics", Json::array()}}}});
  }
}

void Server::PublishDiagnostics() {
  for (auto& [uri, document] : documents_.all()) {
    if (document.is_published) continue;
    document.is_published = true;
    Json diagnostics = Json::array();
    try {
      diagnostics = DiagnosticsOf(*documents_.Analyse(document));
    } catch (const std::exception& error) {
      // An error, for example a plug-in that cannot be loaded, must not end the server.
      diagnostics.push_back({{"range", RangeJson({})},
                             {"severity", 1},
                             {"source", "cdb"},
                             {"message", error.what()}});
    }
    Send({{"jsonrpc", "2.0"},
          {"method", "textDocument/publishDiagnostics"},
          {"params", {{"uri", uri}, {"version", document.version}, {"diagnostics", diagnostics}}}});
  }
}

Json Server::Answer(const std::string& method, const Json& params) {
  if (method == "initialize") {
    if (is_initialized_) throw Failure{kInvalidRequest, "`initialize` must come only once"};
    is_initialized_ = true;
    return Initialize();
  }
  if (method == "shutdown") {
    is_shut_down_ = true;
    return nullptr;
  }
  if (!method.starts_with("textDocument/"))
    throw Failure{kMethodNotFound, fmt::format("there is no method '{}'", method)};
  const std::string uri = TextIn(Member(params, "textDocument"), "uri");
  Document* document = documents_.Find(uri);
  if (document == nullptr) throw Failure{kInvalidParams, fmt::format("'{}' is not open", uri)};
  return AnswerAbout(method, *document, params);
}

Json Server::AnswerAbout(const std::string& method, Document& document, const Json& params) {
  if (method == "textDocument/formatting") return Format(document);
  const std::shared_ptr<const Analysis> analysis = documents_.Analyse(document);
  const std::uint32_t offset = OffsetOf(analysis->source(), PositionIn(params, "position"));
  if (method == "textDocument/completion")
    return Complete(*analysis, document.path, offset, options_.library);
  if (method == "textDocument/hover") return HoverAt(*analysis, offset);
  if (method == "textDocument/definition")
    return DefinitionOf(*analysis, document.path, offset, options_.library);
  if (method == "textDocument/references") return ReferencesTo(*analysis, offset);
  if (method == "textDocument/documentSymbol") return SymbolsOf(*analysis);
  if (method == "textDocument/inlayHint") return InlayHints(*analysis);
  if (method == "textDocument/prepareRename") return PrepareRename(*analysis, offset);
  if (method == "textDocument/rename")
    return Rename(documents_, document, offset, TextIn(params, "newName"), options_.library);
  throw Failure{kMethodNotFound, fmt::format("there is no method '{}'", method)};
}

Json Server::Initialize() {
  return {{"capabilities",
           {{"positionEncoding", "utf-16"},
            {"textDocumentSync", {{"openClose", true}, {"change", 2}}},
            {"completionProvider", {{"triggerCharacters", {".", "\"", "("}}}},
            {"hoverProvider", true},
            {"definitionProvider", true},
            {"referencesProvider", true},
            {"documentSymbolProvider", true},
            {"documentFormattingProvider", true},
            {"renameProvider", {{"prepareProvider", true}}},
            {"inlayHintProvider", true}}},
          {"serverInfo", {{"name", "cdb"}, {"version", options_.version}}}};
}

Json Server::Format(const Document& document) {
  const auto source = std::make_shared<const text::Source>(document.path, document.text);
  dsl::Diagnostics diagnostics;
  dsl::Parse(source, diagnostics);
  if (diagnostics.has_errors())
    throw Failure{kRequestFailed, "a text with syntax errors cannot be formatted"};
  const std::string formatted = dsl::Format(*source);
  if (formatted == source->text()) return Json::array();
  const text::Span whole{source.get(), 0, static_cast<std::uint32_t>(source->text().size())};
  return Json::array({{{"range", RangeJson(whole)}, {"newText", formatted}}});
}

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
      if (parameter.grouped == context_.is_grouped && parameter.name.starts_with(prefix) &&
          parameter.NamedBlock() == schema::NamedBlockOf(context_.block))
        Add(std::string(parameter.name.substr(prefix.size())), ItemKind::kProperty, parameter.doc);
    for (const std::string_view block : schema::BlocksIn(context_.block, context_.is_grouped))
      Add(std::string(block), ItemKind::kModule, "a block");
    AddWord("let", ItemKind::kKeyword);
    if (context_.is_grouped || !context_.block.empty()) return;
    for (const char* word : {"objects", "joints", "queries", "cases", "skip"})
      AddWord(word, ItemKind::kKeyword);
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
      if (word.role != schema::WordRole::kFunction) continue;
      const bool makes_axis = evaluate::MakesAxis(word.name);
      const bool fits = context_.parameter == nullptr || context_.parameter->distribution;
      if (makes_axis || fits) AddWord(word.name, ItemKind::kFunction);
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
