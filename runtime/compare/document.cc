#include "runtime/compare/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "runtime/terminal/table.h"

namespace cdb::compare {
namespace {

constexpr std::size_t kLineWidth = 100;

/// Breaks lines at spaces; continuation lines are indented by four more.
std::string Wrapped(const std::string& line, const std::string& indent) {
  std::string text, current = indent;
  std::istringstream words(line);
  bool is_first = true;
  for (std::string word; words >> word; is_first = false) {
    if (!is_first && current.size() + 1 + word.size() > kLineWidth) {
      text += current + "\n";
      current = indent + "    " + word;
    } else {
      current += (is_first ? "" : " ") + word;
    }
  }
  return text + current + "\n";
}

/// Escapes the characters that Markdown would interpret.
std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string_view("|*_`<>[]\\").find(c) != std::string_view::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string TableText(const DocumentTable& of) {
  terminal::Table table;
  for (const auto& [head, right] : of.columns) table.AddColumn(head, right);
  for (const auto& row : of.rows) table.AddRow(row);
  return table.Text();
}

std::string MarkdownTable(const DocumentTable& of) {
  std::string heads = "|", rules = "|", rows;
  for (const auto& [head, right] : of.columns) {
    heads += fmt::format(" {} |", Escaped(head));
    rules += right ? " ---: |" : " --- |";
  }
  for (const auto& row : of.rows) {
    rows += "|";
    for (const std::string& cell : row) rows += fmt::format(" {} |", Escaped(cell));
    rows += "\n";
  }
  return heads + "\n" + rules + "\n" + rows;
}

}  // namespace

std::string TerminalText(const Document& document) {
  std::string text;
  for (const DocumentSection& section : document) {
    text += (text.empty() ? "" : "\n") + section.title + "\n";
    for (const std::string& line : section.lines) text += Wrapped(line, "  ");
    if (!section.table.rows.empty()) text += TableText(section.table);
    for (const std::string& note : section.notes) text += Wrapped(note, "  ");
  }
  return text;
}

std::string MarkdownText(const Document& document) {
  std::string text;
  for (const DocumentSection& section : document) {
    text += fmt::format("{}### {}\n\n", text.empty() ? "" : "\n", Escaped(section.title));
    for (const std::string& line : section.lines) text += fmt::format("- {}\n", Escaped(line));
    if (!section.table.rows.empty())
      text += (section.lines.empty() ? "" : "\n") + MarkdownTable(section.table);
    for (const std::string& note : section.notes) text += fmt::format("\n{}\n", Escaped(note));
  }
  return text;
}

std::string FourDigits(double value) {
  if (!std::isfinite(value)) return "-";
  if (std::fabs(value) >= 1000 && std::fabs(value) < 1e7) return fmt::format("{:.0f}", value);
  return fmt::format("{:#.4g}", value);
}

std::string PercentText(double ratio) {
  return std::isfinite(ratio) ? fmt::format("{:+.1f} %", 100 * (ratio - 1)) : "-";
}

std::string PercentRange(double low, double high) {
  if (!std::isfinite(low) || !std::isfinite(high)) return "-";
  return fmt::format("{:+.1f} .. {:+.1f} %", 100 * (low - 1), 100 * (high - 1));
}

std::string TimeText(double ns, double like_ns) {
  const terminal::TimeUnit unit = terminal::TimeUnit::For(like_ns);
  return fmt::format("{} {}", FourDigits(ns / unit.ns), unit.name);
}

}  // namespace cdb::compare
