// Syntax files of editors, made from the tables of the language.
#pragma once

#include <string>

namespace cdb::editor {

/// A TextMate grammar, for VS Code and other editors that support the format.
std::string TextMateGrammar();
std::string VimSyntax();
/// The words of each class, as JSON: statements, modifiers, functions, constants, parameters,
/// blocks, words. A word is in one class only.
std::string VocabularyJson();

}  // namespace cdb::editor
