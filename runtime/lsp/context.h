// What may stand at a place of a text, whether or not the text around it parses.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "dsl/text/source.h"

namespace cdb::lsp {

enum class Expected {
  kNothing,    ///< a comment, a new name
  kItem,       ///< of a file: use, let, benchmark
  kStatement,  ///< of a block
  kValue,      ///< of `parameter`, or of a let
  kCondition,  ///< after `skip when`
  kBase,       ///< a benchmark, after `from`
  kFile,       ///< after `use`
};

struct Context {
  Expected expected = Expected::kNothing;
  std::uint32_t begin = 0, end = 0;                ///< the word or the text that is being written
  std::string prefix;                              ///< of it, up to the place
  std::string group, block;                        ///< as of scenario::Scope
  bool is_grouped = false;                         ///< inside objects { }
  const schema::Parameter* parameter = nullptr;    ///< that is being set, or compared
  const schema::ParametrisedWord* word = nullptr;  ///< whose arguments are being written
};

/// At the byte `offset`.
Context ContextAt(const text::Source& source, std::uint32_t offset);

/// The parameter that a path names in a block; null if there is none.
const schema::Parameter* ParameterAt(const Context& context, const std::string& path);

}  // namespace cdb::lsp
