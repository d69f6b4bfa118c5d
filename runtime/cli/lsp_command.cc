// `cdb lsp`: the language server on standard input and output.
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <optional>
#include <string>

#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/editor/message_stream.h"
#include "runtime/editor/server.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

/// Diagnostics are sent when nothing has been typed for this time, ms.
constexpr int kQuietTime = 150;

/// False at the end of standard input.
bool ReadMore(editor::MessageReader& reader) {
  char bytes[1 << 16];
  ssize_t count = 0;
  do count = read(STDIN_FILENO, bytes, sizeof bytes);
  while (count < 0 && errno == EINTR);
  if (count <= 0) return false;
  reader.Add({bytes, static_cast<std::size_t>(count)});
  return true;
}

bool IsQuiet() {
  pollfd input = {STDIN_FILENO, POLLIN, 0};
  return poll(&input, 1, kQuietTime) == 0;
}

options::ExitStatus ServeLanguage() {
  const auto compile = [](const std::string& path, const scenario::ReadFile& read) {
    return options::CompileWith(path, read, std::nullopt, {}, /*lists_runs=*/false);
  };
  const auto send = [](const std::string& message) {
    terminal::PrintExact(editor::Framed(message));
    terminal::Flush();
  };
  editor::Server server({compile, options::ScenarioLibrary(), CDB_VERSION, send});
  editor::MessageReader reader;
  while (!server.has_ended()) {
    if (const auto message = reader.Next()) {
      server.Handle(*message);
      continue;
    }
    if (reader.is_broken())
      throw options::CommandError(
          "standard input is not the language server protocol; editors start this command");
    if (IsQuiet()) server.PublishDiagnostics();
    if (!ReadMore(reader)) break;
  }
  return server.ended_well() ? options::ExitStatus::kGood : options::ExitStatus::kScenarioError;
}

void DeclareLsp(options::Subcommand& command) {
  command.Action([] { return ServeLanguage(); });
}

}  // namespace

/// Runs the language server until the editor ends it.
options::Command LspCommand() {
  return {.name = "lsp",
          .help = "run the language server for editors, on standard input and output",
          .declare = DeclareLsp};
}

}  // namespace cdb::cli
