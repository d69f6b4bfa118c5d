// The words of the language itself: statements, functions, and words within values. `cdb doc`, the
// language server, and the syntax files of editors read this table; words of parameters are in
// schema.h and catalogue.h.
#pragma once

#include <span>
#include <string_view>

namespace cdb::schema {

enum class WordRole {
  kStatement,  ///< begins a statement: `let`
  kFunction,   ///< makes a value from arguments: `sweep`
  kModifier,   ///< is part of a statement or a value: `from`, `step`, `and`
  kConstant,   ///< is a value: `on`
};

struct LanguageWord {
  std::string_view name;
  WordRole role;
  std::string_view syntax;   ///< `let NAME = VALUE`
  std::string_view doc;      ///< one line
  std::string_view example;  ///< lines of a benchmark, or whole items of a file
};

/// In the order in which `cdb doc language` introduces them.
std::span<const LanguageWord> LanguageWords();
/// Null if there is none.
const LanguageWord* FindLanguageWord(std::string_view name);

}  // namespace cdb::schema
