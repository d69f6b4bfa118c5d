// The texts that the editor has open, and what the compiler says of them.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "compiler/compile.h"
#include "runtime/lsp/json.h"
#include "runtime/lsp/symbols.h"

namespace cdb::lsp {

/// Compiles `path` with the files that `read` gives.
using CompileFile =
    std::function<compiler::Compilation(const std::string& path, const scenario::ReadFile& read)>;

struct Analysis {
  compiler::Compilation compilation;
  Symbols symbols;
  /// The text that was compiled.
  const text::Source& source() const;
};

struct Document {
  std::string uri, path;
  std::string text;
  std::int64_t version = 0;
  bool is_published = false;                 ///< its diagnostics are those of its text
  std::shared_ptr<const Analysis> analysis;  ///< null until it is asked for
};

/// Not thread-safe.
class Documents {
 public:
  explicit Documents(CompileFile compile) : compile_(std::move(compile)) {}

  void Open(const Json& item);
  /// Changes in their order: parts of the text, or all of it.
  void Change(const std::string& uri, std::int64_t version, const Json& changes);
  void Close(const std::string& uri) { open_.erase(uri); }
  /// Null if it is not open.
  Document* Find(const std::string& uri);
  std::map<std::string, Document>& all() { return open_; }

  /// Of its present text.
  std::shared_ptr<const Analysis> Analyse(Document& document);
  /// As if the open texts at these paths were others.
  compiler::Compilation CompileWith(const std::string& path,
                                    const std::map<std::string, std::string>& edited) const;

 private:
  /// A change shows in every text that uses the changed one.
  void ForgetAnalyses();

  CompileFile compile_;
  std::map<std::string, Document> open_;  ///< by address
};

}  // namespace cdb::lsp
