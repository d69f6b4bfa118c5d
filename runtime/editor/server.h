// The language server: takes requests and sends answers.
#pragma once

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

#include "runtime/editor/documents.h"

namespace cdb::editor {

struct ServerOptions {
  CompileFile compile;
  std::string library;  ///< folder of the scenarios that come with cdb; may be empty
  std::string version;
  std::function<void(const std::string& message)> send;  ///< JSON, without its head
};

/// Serves one client. No client input makes it throw: a malformed message is answered by an error,
/// or ignored if it expects no answer. Not thread-safe. Source: Language Server Protocol 3.17.
class Server {
 public:
  explicit Server(ServerOptions options);

  void Handle(const std::string& message);
  /// Sends the diagnostics of texts that changed. Call it when no message is waiting.
  void PublishDiagnostics();

  bool has_ended() const { return has_ended_; }
  /// The client sent `shutdown` before `exit`.
  bool ended_well() const { return is_shut_down_; }

 private:
  struct Failure {
    int code;
    std::string message;
  };

  void Request(const Json& id, const std::string& method, const Json& params);
  void Notification(const std::string& method, const Json& params);
  Json Answer(const std::string& method, const Json& params);
  Json AnswerAbout(const std::string& method, Document& document, const Json& params);
  Json Initialize();
  Json Format(const Document& document);
  void Send(const Json& message);
  void SendError(const Json& id, const Failure& failure);

  const ServerOptions options_;
  Documents documents_;
  bool is_initialized_ = false, is_shut_down_ = false, has_ended_ = false;
};

// Completion: the words that are allowed at a position.

/// A list of CompletionItem. `library`: the folder of the scenarios that come with cdb.
Json Complete(const Analysis& analysis, const std::string& path, std::uint32_t offset,
              const std::string& library);

// Renames a let and all its uses.

/// The name cannot be changed; the message gives the reason.
struct RenameError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The range of the let's name at this position. Throws RenameError.
Json PrepareRename(const Analysis& analysis, std::uint32_t offset);

/// Returns a WorkspaceEdit. The edited texts are compiled, and nothing is changed if the runs would
/// differ. Throws RenameError.
Json Rename(Documents& documents, Document& document, std::uint32_t offset, const std::string& name,
            const std::string& library);

}  // namespace cdb::editor
