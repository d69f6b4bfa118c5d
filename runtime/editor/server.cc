#include "runtime/editor/server.h"

#include <fmt/format.h>

#include <exception>
#include <utility>

#include "dsl/format.h"
#include "dsl/parser.h"
#include "runtime/editor/completion.h"
#include "runtime/editor/features.h"
#include "runtime/editor/rename.h"

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

}  // namespace cdb::editor
