#include "runtime/printers/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

constexpr std::size_t kLineWidth = 100;

/// Breaks a line at spaces; continuation lines are indented by four more.
std::string Wrapped(const std::string& line) {
  const std::string indent = "  ";
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

/// The line without leading spaces; `is_part` if it had some.
std::string_view Stripped(std::string_view line, bool& is_part) {
  is_part = line.starts_with(' ');
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  return line;
}

class TerminalPrinter {
 public:
  explicit TerminalPrinter(bool is_wrapped) : is_wrapped_(is_wrapped) {}

  std::string operator()(const Section& section) const {
    std::string text = section.title.empty() ? "" : section.title + "\n";
    for (const std::string& line : section.lines) text += LineOf(line);
    if (!section.table.rows.empty()) text += TableOf(section.table);
    text += section.plot;
    for (const std::string& note : section.notes) text += LineOf(note);
    return text;
  }

 private:
  std::string LineOf(const std::string& line) const {
    return is_wrapped_ ? Wrapped(line) : "  " + line + "\n";
  }
  static std::string TableOf(const Table& of) {
    terminal::Table table(of.keys);
    for (const Table::Column& column : of.columns) table.AddColumn(column.head, column.is_number);
    for (const auto& row : of.rows) table.AddRow(row);
    return table.Text();
  }

  const bool is_wrapped_;
};

/// Puts `\` before each of `characters`.
std::string Escaped(std::string_view text, std::string_view characters) {
  std::string escaped;
  for (const char c : text) {
    if (characters.find(c) != std::string_view::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string InMarkdown(std::string_view text) { return Escaped(text, "|*_`<>[]\\"); }

std::string MarkdownTable(const Table& of) {
  std::string heads = "|", rules = "|", rows;
  for (const Table::Column& column : of.columns) {
    heads += fmt::format(" {} |", InMarkdown(column.head));
    rules += column.is_number ? " ---: |" : " --- |";
  }
  for (const auto& row : of.rows) {
    rows += "|";
    for (std::size_t i = 0; i < of.columns.size(); ++i)
      rows += fmt::format(" {} |", i < row.size() ? InMarkdown(row[i]) : "");
    rows += "\n";
  }
  return heads + "\n" + rules + "\n" + rows;
}

std::string MarkdownSection(const Section& section) {
  std::string text;
  const auto add = [&](const std::string& part) {
    if (!part.empty()) text += (text.empty() ? "" : "\n") + part;
  };
  if (!section.title.empty()) add(fmt::format("### {}\n", InMarkdown(section.title)));
  std::string lines;
  bool is_part = false;
  for (const std::string& line : section.lines) {
    const std::string_view stripped = Stripped(line, is_part);
    lines += fmt::format("{}- {}\n", is_part ? "  " : "", InMarkdown(stripped));
  }
  add(lines);
  if (!section.table.rows.empty()) add(MarkdownTable(section.table));
  if (!section.plot.empty()) add("```\n" + section.plot + "```\n");
  for (const std::string& note : section.notes) add(InMarkdown(Stripped(note, is_part)) + "\n");
  return text;
}

std::string InLatex(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\')
      escaped += "\\textbackslash{}";
    else if (c == '~' || c == '^')
      escaped += fmt::format("\\{}{{}}", c);
    else if (c == '<' || c == '>' || c == '|')
      escaped += fmt::format("${}$", c);
    else
      escaped += Escaped(std::string_view(&c, 1), "&%$#_{}");
  }
  // A range.
  for (std::size_t at = 0; (at = escaped.find(" .. ", at)) != escaped.npos;)
    escaped.replace(at, 4, "--");
  return escaped;
}

std::string LatexTable(const Table& of) {
  std::string text = "\\begin{tabular}{";
  for (const Table::Column& column : of.columns) text += column.is_number ? 'r' : 'l';
  text += "}\n\\toprule\n";
  const auto add_row = [&](auto cell_of) {
    for (std::size_t i = 0; i < of.columns.size(); ++i)
      text += (i == 0 ? "" : " & ") + InLatex(cell_of(i));
    text += " \\\\\n";
  };
  add_row([&](std::size_t i) { return of.columns[i].head; });
  text += "\\midrule\n";
  for (const auto& row : of.rows)
    add_row([&](std::size_t i) { return i < row.size() ? row[i] : std::string(); });
  return text + "\\bottomrule\n\\end{tabular}\n";
}

/// Sentences that are not of a table are comments, so that the text can be included anywhere.
std::string LatexSection(const Section& section) {
  std::string text;
  const auto comment = [&](const std::string& line) { text += "% " + line + "\n"; };
  if (!section.title.empty()) comment(section.title);
  for (const std::string& line : section.lines) comment(line);
  if (!section.table.rows.empty()) text += LatexTable(section.table);
  std::istringstream plot(section.plot);
  for (std::string line; std::getline(plot, line);) comment(line);
  for (const std::string& note : section.notes) comment(note);
  return text;
}

template <typename Printer>
std::string Joined(const Document& document, Printer printer) {
  std::string text;
  for (const Section& section : document) text += (text.empty() ? "" : "\n") + printer(section);
  return text;
}

}  // namespace

std::string TextOf(const Document& document, Format format) {
  switch (format) {
    case Format::kMarkdown:
      return Joined(document, MarkdownSection);
    case Format::kLatex:
      return Joined(document, LatexSection);
    case Format::kTerminal:
    case Format::kWrapped:
      break;
  }
  return Joined(document, TerminalPrinter(format == Format::kWrapped));
}

std::string CsvField(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string field = "\"";
  for (const char c : text) {
    if (c == '"') field += '"';
    field += c;
  }
  return field + '"';
}

std::string CsvOf(const Table& table) {
  std::string text;
  const auto add_line = [&](const auto& cells, auto text_of) {
    for (std::size_t i = 0; i < cells.size(); ++i)
      text += (i == 0 ? "" : ",") + CsvField(text_of(cells[i]));
    text += '\n';
  };
  add_line(table.columns, [](const Table::Column& column) { return column.head; });
  for (const auto& row : table.rows) add_line(row, [](const std::string& cell) { return cell; });
  return text;
}

}  // namespace cdb::printers
