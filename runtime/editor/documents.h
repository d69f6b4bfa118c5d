// The texts that the editor has open, with the compiler's diagnostics.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "compiler/compile.h"
#include "runtime/editor/json.h"
#include "runtime/editor/symbols.h"

namespace cdb::editor {

/// Compiles `path` with the files returned by `read`.
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
  bool is_published = false;                 ///< the published diagnostics are those of the present
                                             ///< text
  std::shared_ptr<const Analysis> analysis;  ///< null until it is requested
};

/// Not thread-safe.
class Documents {
 public:
  explicit Documents(CompileFile compile) : compile_(std::move(compile)) {}

  void Open(const Json& item);
  /// Applies changes in their order: to parts of the text, or to all of it.
  void Change(const std::string& uri, std::int64_t version, const Json& changes);
  void Close(const std::string& uri) { open_.erase(uri); }
  /// Null if it is not open.
  Document* Find(const std::string& uri);
  std::map<std::string, Document>& all() { return open_; }

  /// The analysis of the present text.
  std::shared_ptr<const Analysis> Analyse(Document& document);
  /// Compiles with the given texts in place of the open ones at these paths.
  compiler::Compilation CompileWith(const std::string& path,
                                    const std::map<std::string, std::string>& edited) const;

 private:
  /// A change affects every text that uses the changed one.
  void ForgetAnalyses();

  CompileFile compile_;
  std::map<std::string, Document> open_;  ///< by URI
};

}  // namespace cdb::editor
