#include "runtime/manual/explanation.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/terminal/table.h"
#include "runtime/terminal/wrap.h"

namespace cdb::manual {
namespace {

bool IsSameWord(std::string_view a, std::string_view b) {
  const auto lower = [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  return std::ranges::equal(a, b, {}, lower, lower);
}

/// Indents each line by four spaces. Cuts long lines, and replaces bytes that are not text.
std::string ExampleText(std::string_view text) {
  constexpr std::size_t kLongest = 90;
  std::string indented;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    indented += "    ";
    for (const char c : line.substr(0, kLongest)) {
      const auto byte = static_cast<unsigned char>(c);
      indented += byte < 0x20 || byte == 0xE9 ? std::string("\uFFFD") : std::string(1, c);
    }
    indented += line.size() > kLongest ? "…\n" : "\n";
  }
  return indented;
}

}  // namespace

std::vector<const Explanation*> AllExplanations() {
  std::vector<const Explanation*> all;
  for (const auto rows : {SyntaxExplanations(), ScenarioExplanations(), LintExplanations()})
    for (const Explanation& row : rows) all.push_back(&row);
  return all;
}

std::vector<const Explanation*> FindExplanations(std::string_view wanted) {
  std::vector<const Explanation*> found;
  for (const Explanation* row : AllExplanations())
    if (IsSameWord(row->kind->code, wanted) || IsSameWord(row->kind->id, wanted))
      found.push_back(row);
  return found;
}

std::string ExplanationText(const Explanation& explanation, std::string_view rendered) {
  const bool is_error = explanation.kind->severity() == dsl::Severity::kError;
  return fmt::format("{} {} ({})\n{}\nWRONG\n{}\n{}\nRIGHT\n{}", explanation.kind->code,
                     explanation.kind->id, is_error ? "error" : "warning",
                     terminal::Wrapped(explanation.text, 2), ExampleText(explanation.wrong),
                     rendered, ExampleText(explanation.right));
}

std::string ExplanationList() {
  terminal::Table table;
  table.KeepWhole();
  for (const char* head : {"code", "name", ""}) table.AddColumn(head, false);
  for (const Explanation* row : AllExplanations()) {
    std::string_view sentence = row->text.substr(0, row->text.find(". "));
    if (sentence.ends_with('.')) sentence.remove_suffix(1);
    table.AddRow({std::string(row->kind->code), std::string(row->kind->id), std::string(sentence)});
  }
  return table.Text();
}

}  // namespace cdb::manual
