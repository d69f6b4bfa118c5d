// The texts that the editor has open, with the compiler's diagnostics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/compile.h"
#include "compiler/scenario/scenario.h"
#include "dsl/syntax.h"
#include "dsl/text/source.h"

namespace cdb::editor {

// Names in a scenario and their definitions: lets, benchmarks and groups of objects.

enum class SymbolKind { kLet, kBenchmark, kGroup };

struct Definition {
  SymbolKind kind;
  text::Span name;
  text::Span whole;                           ///< the let, or the head of the block
  std::string block;                          ///< for a let, the blocks around it: `objects.links`
  const dsl::Benchmark* benchmark = nullptr;  ///< the enclosing benchmark; null outside of
                                              ///< benchmarks
  /// Definitions of one family share a meaning: a let, and those that override it.
  std::size_t family = 0;
};

/// A name that is a definition or a reference to one.
struct Occurrence {
  text::Span span;
  std::size_t definition = 0;  ///< index into definitions()
};

/// The symbols of the main file and all files that it uses. Points into the scenario.
class Symbols {
 public:
  explicit Symbols(const scenario::Scenario& scenario);

  std::span<const Definition> definitions() const { return definitions_; }
  std::span<const Occurrence> occurrences() const { return occurrences_; }
  /// Null if no name of the source touches the byte.
  const Occurrence* At(const text::Source& source, std::uint32_t offset) const;
  /// Every occurrence of the family of `definition`, each once.
  std::vector<text::Span> FamilyOf(std::size_t definition) const;

 private:
  friend class SymbolCollector;
  std::vector<Definition> definitions_;
  std::vector<Occurrence> occurrences_;
};

// Positions in a text as the protocol counts them: lines and UTF-16 code units, both from 0.

struct Position {
  std::int64_t line = 0;
  std::int64_t character = 0;
};

/// The position of a byte; within a character, that of its first byte. A byte that is not UTF-8
/// counts as one unit.
Position PositionOf(const text::Source& source, std::uint32_t offset);

/// The byte at a position. Beyond the end of a line, the end of that line; beyond the last line,
/// the end of the text; before the first line, its begin.
std::uint32_t OffsetOf(const text::Source& source, const Position& position);

/// `file:///tmp/a%20b.cdb` as a path. Other URIs, such as those of unsaved texts, are unchanged.
std::string PathOf(const std::string& uri);
std::string UriOf(const std::string& path);

// Reads untrusted JSON: values that are missing or have another type become defaults.

using Json = nlohmann::json;

/// null if `object` is not an object, or has no such member.
const Json& Member(const Json& object, const char* name);
std::string TextIn(const Json& object, const char* name);
/// 0 if the member is not a whole number.
std::int64_t NumberIn(const Json& object, const char* name);
Position PositionIn(const Json& object, const char* name);

Json ToJson(const Position& position);
/// The range of a span of `source`.
Json RangeJson(const text::Span& span);

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
  /// From now on, models and their hashes are kept in memory (plan::KeepFiles), as each change of a
  /// text compiles it.
  explicit Documents(CompileFile compile);

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
