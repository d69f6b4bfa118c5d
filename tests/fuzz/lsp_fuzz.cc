// Any lines as the messages of a client, and any bytes as their stream: it does not crash, and
// every answer is JSON with an id.
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "compiler/compile.h"
#include "dsl/text/check.h"
#include "runtime/editor/message_stream.h"
#include "runtime/editor/server.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cdb;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto compile = [](const std::string& path, const scenario::ReadFile& read) {
    // No file on the disk is used.
    const auto open_only = [&](const std::string& wanted,
                               std::string& why) -> std::optional<std::string> {
      if (wanted == path) return read(wanted, why);
      why = "No such file or directory";
      return std::nullopt;
    };
    return compiler::Compile(path, open_only, {});
  };
  const auto send = [](const std::string& message) {
    const nlohmann::json json = nlohmann::json::parse(message);
    CDB_CHECK(json.contains("id") || json.contains("method"));
  };
  editor::Server server({compile, "", "1", send});
  server.Handle(R"({"jsonrpc":"2.0","id":0,"method":"initialize","params":{}})");
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) server.Handle(line);
  server.PublishDiagnostics();

  editor::MessageReader reader;
  reader.Add(text);
  while (reader.Next()) continue;
  return 0;
}
