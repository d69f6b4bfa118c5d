#include "runtime/editor/syntax_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <vector>

#include "compiler/schema/language_words.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"

namespace cdb::editor {
namespace {

using OrderedJson = nlohmann::ordered_json;
using Words = std::vector<std::string>;

struct Vocabulary {
  Words statements, modifiers, functions, constants, parameters, blocks, words;
};

Words WordsOfRole(schema::WordRole role) {
  Words words;
  for (const schema::LanguageWord& word : schema::LanguageWords())
    if (word.role == role) words.emplace_back(word.name);
  return words;
}

/// `world.side`, and `side`, its name inside world { }.
std::set<std::string> ParameterNames() {
  std::set<std::string> names;
  for (const schema::Parameter& parameter : schema::Schema()) {
    names.insert(parameter.FullName());
    for (std::string_view rest = parameter.name;;) {
      names.emplace(rest);
      const std::size_t dot = rest.find('.');
      if (dot == std::string_view::npos) break;
      rest.remove_prefix(dot + 1);
    }
  }
  return names;
}

std::set<std::string> BlockNames() {
  std::set<std::string> blocks;
  for (const schema::Parameter& parameter : schema::Schema())
    for (std::string_view rest = parameter.name; rest.find('.') != std::string_view::npos;
         rest.remove_prefix(rest.find('.') + 1))
      blocks.emplace(rest.substr(0, rest.find('.')));
  return blocks;
}

Vocabulary MakeVocabulary() {
  using enum schema::WordRole;
  Vocabulary all;
  all.statements = WordsOfRole(kStatement);
  all.modifiers = WordsOfRole(kModifier);
  all.functions = WordsOfRole(kFunction);
  all.constants = WordsOfRole(kConstant);
  std::set<std::string> taken;
  for (const Words* words : {&all.statements, &all.modifiers, &all.functions, &all.constants})
    taken.insert(words->begin(), words->end());
  const auto add = [&taken](const std::set<std::string>& names, Words& words) {
    for (const std::string& name : names)
      if (taken.insert(name).second) words.push_back(name);
  };
  add(ParameterNames(), all.parameters);
  add(BlockNames(), all.blocks);
  std::set<std::string> words;
  for (const schema::Parameter& parameter : schema::Schema())
    for (const std::string_view word : parameter.AllWords()) words.emplace(word);
  for (const schema::ParametrisedWord& word : schema::ParametrisedWords()) {
    words.emplace(word.name);
    for (const schema::Parameter& argument : word.arguments)
      for (const std::string_view own : argument.AllWords()) words.emplace(own);
  }
  add(words, all.words);
  return all;
}

/// `(?:b|aa)`, the longest first, so that no alternative hides a longer one that it begins.
std::string Alternatives(Words words) {
  std::ranges::stable_sort(words, std::ranges::greater(), &std::string::size);
  std::string text;
  for (const std::string& word : words) {
    text += text.empty() ? "(?:" : "|";
    for (const char c : word) text += c == '.' ? std::string("\\.") : std::string(1, c);
  }
  return text + ")";
}

std::string WholeWord(const Words& words) {
  return R"((?<![\w.]))" + Alternatives(words) + R"((?![\w.]))";
}

OrderedJson Match(std::string_view name, const std::string& pattern) {
  return {{"name", name}, {"match", pattern}};
}

OrderedJson TextPattern() {
  return {
      {"name", "string.quoted.double.cdb"},
      {"begin", "\""},
      {"end", "\"|$"},
      {"beginCaptures", {{"0", {{"name", "punctuation.definition.string.begin.cdb"}}}}},
      {"endCaptures", {{"0", {{"name", "punctuation.definition.string.end.cdb"}}}}},
      {"patterns", OrderedJson::array({Match("constant.character.escape.cdb", R"(\\["\\nt])")})}};
}

OrderedJson NamedPattern(const char* keyword, const char* scope) {
  return {{"match", fmt::format(R"((?<![\w.])({})\s+([A-Za-z_]\w*))", keyword)},
          {"captures", {{"1", {{"name", "keyword.control.cdb"}}}, {"2", {{"name", scope}}}}}};
}

}  // namespace

std::string TextMateGrammar() {
  const Vocabulary all = MakeVocabulary();
  OrderedJson patterns = OrderedJson::array();
  patterns.push_back({{"name", "comment.line.number-sign.cdb"},
                      {"match", "(#).*$"},
                      {"captures", {{"1", {{"name", "punctuation.definition.comment.cdb"}}}}}});
  patterns.push_back(TextPattern());
  patterns.push_back(NamedPattern("benchmark", "entity.name.type.cdb"));
  patterns.push_back(NamedPattern("let", "variable.other.constant.cdb"));
  patterns.push_back(Match(
      "constant.numeric.cdb",
      R"((?<![\w.])(?:0[xX][0-9A-Fa-f_]+|[0-9][0-9_]*(?:\.[0-9][0-9_]*)?(?:[eE][+-]?[0-9]+)?))"));
  Words blocks = all.blocks;
  for (const std::string& name : BlockNames()) blocks.push_back(name);
  patterns.push_back(
      Match("entity.name.section.cdb", R"((?<![\w.]))" + Alternatives(blocks) + R"((?=\s*\{))"));
  patterns.push_back(Match("keyword.control.cdb", WholeWord(all.statements)));
  patterns.push_back(Match("keyword.other.cdb", WholeWord(all.modifiers)));
  patterns.push_back(Match("support.function.cdb", WholeWord(all.functions)));
  patterns.push_back(Match("constant.language.cdb", WholeWord(all.constants)));
  // Also `pebbles.size`, with the name of a group.
  patterns.push_back(
      Match("variable.parameter.cdb",
            R"((?<![\w.])(?:[A-Za-z_]\w*\.)?)" + Alternatives(all.parameters) + R"((?![\w.]))"));
  patterns.push_back(Match("support.constant.cdb", WholeWord(all.words)));
  const OrderedJson grammar = {
      {"name", "cdb"}, {"scopeName", "source.cdb"}, {"fileTypes", {"cdb"}}, {"patterns", patterns}};
  return grammar.dump(2) + "\n";
}

std::string VimSyntax() {
  const Vocabulary all = MakeVocabulary();
  std::string text =
      "\" The language of cdb; written by `cdb generate vim`.\n"
      "if exists('b:current_syntax')\n  finish\nendif\n\n"
      "syntax iskeyword @,48-57,_,.\n";
  const auto keywords = [&text](const char* group, const Words& words) {
    for (std::size_t i = 0; i < words.size(); i += 8)
      text += fmt::format(
          "syntax keyword {} {}\n", group,
          fmt::join(words.begin() + static_cast<std::ptrdiff_t>(i),
                    words.begin() + static_cast<std::ptrdiff_t>(std::min(i + 8, words.size())),
                    " "));
  };
  keywords("cdbStatement", all.statements);
  keywords("cdbModifier", all.modifiers);
  keywords("cdbFunction", all.functions);
  keywords("cdbConstant", all.constants);
  keywords("cdbParameter", all.parameters);
  keywords("cdbBlock", all.blocks);
  keywords("cdbWord", all.words);
  return text +
         "syntax match cdbNumber "
         "/\\<\\(0[xX][0-9A-Fa-f_]\\+\\|[0-9][0-9_]*\\(\\.[0-9][0-9_]*\\)\\?"
         "\\([eE][+-]\\?[0-9]\\+\\)\\?\\)\\>/\n"
         "syntax match cdbEscape /\\\\[\"\\\\nt]/ contained\n"
         "syntax region cdbText start=/\"/ end=/\"\\|$/ contains=cdbEscape\n"
         "syntax match cdbComment /#.*$/\n\n"
         "highlight default link cdbStatement Statement\n"
         "highlight default link cdbModifier Keyword\n"
         "highlight default link cdbFunction Function\n"
         "highlight default link cdbConstant Boolean\n"
         "highlight default link cdbParameter Identifier\n"
         "highlight default link cdbBlock Structure\n"
         "highlight default link cdbWord Constant\n"
         "highlight default link cdbNumber Number\n"
         "highlight default link cdbEscape SpecialChar\n"
         "highlight default link cdbText String\n"
         "highlight default link cdbComment Comment\n\n"
         "let b:current_syntax = 'cdb'\n";
}

std::string VocabularyJson() {
  const Vocabulary all = MakeVocabulary();
  const OrderedJson json = {{"statements", all.statements},
                            {"modifiers", all.modifiers},
                            {"functions", all.functions},
                            {"constants", all.constants},
                            {"parameters", all.parameters},
                            {"blocks", all.blocks},
                            {"words", all.words}};
  return json.dump() + "\n";
}

}  // namespace cdb::editor
