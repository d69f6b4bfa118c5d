// A client of the language server that runs in the same process.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compiler/compile.h"
#include "runtime/editor/server.h"

namespace cdb::tests {

using Json = nlohmann::json;

class Client {
 public:
  explicit Client(bool initialize = true)
      : server_({[this](const std::string& path, const scenario::ReadFile& read) {
                   ++compilations_;
                   const auto with_files = [&](const std::string& wanted,
                                               std::string& why) -> std::optional<std::string> {
                     const auto file = files.find(wanted);
                     return file != files.end() ? file->second : read(wanted, why);
                   };
                   return compiler::Compile(path, with_files, {"/lib", std::nullopt, {}});
                 },
                 "/lib", "1",
                 [this](const std::string& message) { sent.push_back(Json::parse(message)); }}) {
    if (initialize) Ask("initialize", {{"capabilities", Json::object()}});
  }

  /// Sends a request and returns the whole answer.
  Json Ask(const std::string& method, const Json& params) {
    server_.Handle(
        Json({{"jsonrpc", "2.0"}, {"id", ++id_}, {"method", method}, {"params", params}}).dump());
    return sent.empty() ? Json() : sent.back();
  }
  void Tell(const std::string& method, const Json& params) {
    server_.Handle(Json({{"jsonrpc", "2.0"}, {"method", method}, {"params", params}}).dump());
  }

  void Open(const std::string& uri, const std::string& text) {
    Tell("textDocument/didOpen",
         {{"textDocument", {{"uri", uri}, {"languageId", "cdb"}, {"version", 1}, {"text", text}}}});
  }
  /// The result of a request about a position in a document.
  Json At(const std::string& method, const std::string& uri, int line, int character,
          const Json& more = Json::object()) {
    Json params = {{"textDocument", {{"uri", uri}}},
                   {"position", {{"line", line}, {"character", character}}}};
    params.update(more);
    return Ask("textDocument/" + method, params)["result"];
  }
  /// The diagnostics now published for the document; null if there are none.
  Json Diagnostics(const std::string& uri) {
    sent.clear();
    server_.PublishDiagnostics();
    for (const Json& message : sent)
      if (message["params"]["uri"] == uri) return message["params"]["diagnostics"];
    return nullptr;
  }

  editor::Server& server() { return server_; }
  int compilations() const { return compilations_; }

  std::vector<Json> sent;
  std::map<std::string, std::string> files;  ///< files in place of the disk

 private:
  editor::Server server_;
  int id_ = 0;
  int compilations_ = 0;
};

}  // namespace cdb::tests
