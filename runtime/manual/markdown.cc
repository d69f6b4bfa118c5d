#include "runtime/manual/markdown.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "runtime/terminal/console.h"
#include "runtime/terminal/table.h"

namespace cdb::manual {
namespace {

enum class Kind { kParagraph, kItem, kTable, kCode };

/// A paragraph or an item is one line, without the dash; tables and code keep theirs.
struct Block {
  Kind kind;
  std::string text;
};

/// Takes the first line off `text`.
std::string_view TakeLine(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(text.size(), line.size() + 1));
  return line;
}

std::string_view Trimmed(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

std::vector<Block> Blocks(std::string_view body) {
  std::vector<Block> blocks;
  bool is_open = false;  // the next line may continue the last block
  while (!body.empty()) {
    const std::string_view line = TakeLine(body);
    if (line.starts_with("```")) {
      blocks.push_back({Kind::kCode, {}});
      for (std::string_view code; !body.empty() && !(code = TakeLine(body)).starts_with("```");)
        blocks.back().text += std::string(code) + '\n';
      is_open = false;
    } else if (line.starts_with("|")) {
      if (!is_open || blocks.back().kind != Kind::kTable) blocks.push_back({Kind::kTable, {}});
      blocks.back().text += std::string(line) + '\n';
      is_open = true;
    } else if (line.starts_with("- ")) {
      blocks.push_back({Kind::kItem, std::string(line.substr(2))});
      is_open = true;
    } else if (line.empty()) {
      is_open = false;
    } else if (is_open) {
      blocks.back().text.append(" ").append(Trimmed(line));
    } else {
      blocks.push_back({Kind::kParagraph, std::string(line)});
      is_open = true;
    }
  }
  return blocks;
}

/// Without the marks of emphasis, escapes and links; a link to a page elsewhere keeps its address.
/// `code`: what encloses code.
std::string Plain(std::string_view text, std::string_view code = "`") {
  std::string plain;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '`') {
      const std::size_t end = std::min(text.find('`', at + 1), text.size());
      plain.append(code).append(text.substr(at + 1, end - at - 1)).append(code);
      at = end;
    } else if (c == '\\' && at + 1 < text.size()) {
      plain += text[++at];
    } else if (const std::size_t middle = c == '[' ? text.find("](", at) : text.npos;
               middle != text.npos) {
      plain += Plain(text.substr(at + 1, middle - at - 1), code);
      at = text.find(')', middle);
      const std::string_view target = text.substr(middle + 2, at - middle - 2);
      if (target.starts_with("http")) plain.append(" (").append(target).append(")");
    } else if (c != '*') {
      plain += c;
    }
  }
  return plain;
}

/// The text of an item, and the terms before its colon: empty if it does not begin with code.
std::pair<std::string, std::string> TermAndText(const std::string& item) {
  const std::string plain = Plain(item);
  bool is_code = false, has_code = false;
  for (std::size_t at = 0; at < plain.size(); ++at) {
    if (plain[at] == '`') {
      is_code = !is_code;
      has_code = true;
    } else if (!is_code && plain[at] == ':' && has_code) {
      return {Plain(plain.substr(0, at), ""),
              std::string(Trimmed(std::string_view(plain).substr(at + 1)))};
    } else if (!is_code && std::string_view(" ,.").find(plain[at]) == std::string_view::npos) {
      break;
    }
  }
  return {"", plain};
}

std::size_t Columns(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

/// A list: terms in a column of their own, unless most of them are too wide for it.
std::string ListText(const std::vector<std::string>& items, std::size_t width) {
  constexpr std::size_t kIndent = 2, kGap = 2, kWide = 6;
  const std::size_t most = std::min<std::size_t>(28, width / 3);
  std::vector<std::pair<std::string, std::string>> rows;
  std::size_t column = 0, terms = 0, wide = 0;
  for (const std::string& item : items) {
    rows.push_back(TermAndText(item));
    const std::size_t columns = Columns(rows.back().first);
    if (columns > 0) ++terms;
    if (columns > most) ++wide;
    column = std::max(column, std::min(columns, most));
  }
  const std::size_t hang = 2 * wide > terms ? kWide : kIndent + column + kGap;
  std::string text;
  for (const auto& [term, about] : rows) {
    if (hang == kWide && !text.empty()) text += '\n';
    if (term.empty()) {
      text += terminal::Wrapped("- " + about, 2 * kIndent, width).substr(kIndent);
      continue;
    }
    std::string wrapped = terminal::Wrapped(about, hang, width);
    const std::size_t columns = Columns(term);
    if (kIndent + columns + kGap <= hang) {
      wrapped.replace(kIndent, columns, term);
    } else {
      text += terminal::Wrapped(term, 2 * kIndent, width).substr(kIndent);
    }
    text += wrapped;
  }
  return text;
}

std::vector<std::string> CellsOf(std::string_view row) {
  std::vector<std::string> cells;
  std::string cell;
  for (std::size_t at = 1; at < row.size(); ++at) {
    if (row.substr(at, 2) == "\\|") {
      cell += row[++at];
    } else if (row[at] == '|') {
      cells.emplace_back(Trimmed(Plain(std::exchange(cell, {}), "")));
    } else {
      cell += row[at];
    }
  }
  return cells;
}

std::string TableText(std::string_view rows, std::size_t width) {
  terminal::Table table;
  table.KeepWhole();
  const std::vector<std::string> heads = CellsOf(TakeLine(rows));
  const std::vector<std::string> rules = CellsOf(TakeLine(rows));
  for (std::size_t i = 0; i < heads.size(); ++i)
    table.AddColumn(heads[i], i < rules.size() && rules[i].ends_with(':'));
  while (!rows.empty()) table.AddRow(CellsOf(TakeLine(rows)));
  return terminal::Fitted(table.Text(), width);
}

std::string CodeText(std::string_view code) {
  std::string text;
  while (!code.empty()) {
    const std::string_view line = TakeLine(code);
    text += (line.empty() ? "" : "  ") + std::string(line) + '\n';
  }
  return text;
}

std::string ParagraphText(std::string_view text, std::size_t width, const PartOf& part) {
  constexpr std::string_view kBegin = "<!-- ", kEnd = " -->";
  if (const std::size_t mark = text.rfind(kBegin); mark != text.npos && text.ends_with(kEnd)) {
    const std::size_t name = mark + kBegin.size();
    std::string generated = part(text.substr(name, text.size() - kEnd.size() - name));
    if (!generated.empty()) return generated;
  }
  return terminal::Wrapped(Plain(text), 0, width);
}

}  // namespace

std::vector<Section> Sections(std::string_view markdown) {
  std::vector<Section> sections;
  bool is_code = false;
  while (!markdown.empty()) {
    const std::string_view line = TakeLine(markdown);
    if (line.starts_with("```")) is_code = !is_code;
    const std::size_t level = line.find_first_not_of('#');
    if (is_code || level == 0 || level == line.npos) {
      if (sections.empty()) sections.push_back({1, {}, {}});
      sections.back().body += std::string(line) + '\n';
      continue;
    }
    std::string heading = Plain(Trimmed(line.substr(level)));
    bool is_term = level > 2;
    for (char& c : heading) {
      if (c == '`') is_term = !is_term;
      if (!is_term) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    }
    std::erase(heading, '`');
    sections.push_back({static_cast<int>(level), std::move(heading), {}});
  }
  return sections;
}

std::string BodyText(std::string_view body, std::size_t width, const PartOf& part) {
  std::string text;
  const std::vector<Block> blocks = Blocks(body);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!text.empty()) text += '\n';
    const Block& block = blocks[i];
    if (block.kind == Kind::kItem) {
      std::vector<std::string> items = {block.text};
      while (i + 1 < blocks.size() && blocks[i + 1].kind == Kind::kItem)
        items.push_back(blocks[++i].text);
      text += ListText(items, width);
    } else if (block.kind == Kind::kTable) {
      text += TableText(block.text, width);
    } else if (block.kind == Kind::kCode) {
      text += CodeText(block.text);
    } else {
      text += ParagraphText(block.text, width, part);
    }
  }
  return text;
}

std::string PageText(std::string_view markdown, std::size_t width, const PartOf& part) {
  std::string text;
  for (const Section& section : Sections(markdown)) {
    if (!text.empty()) text += '\n';
    text += section.heading + '\n';
    const std::string body = BodyText(section.body, width, part);
    if (!body.empty()) text += '\n' + body;
  }
  return text;
}

}  // namespace cdb::manual
