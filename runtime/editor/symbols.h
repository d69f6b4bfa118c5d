// Names in a scenario and their definitions: lets, benchmarks and groups of objects.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/scenario/scenario.h"
#include "dsl/syntax.h"

namespace cdb::editor {

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

}  // namespace cdb::editor
