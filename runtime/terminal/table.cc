#include "runtime/terminal/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "compiler/plan/plan.h"
#include "runtime/terminal/console.h"

namespace cdb::terminal {
namespace {

/// Columns of a page where the output is not a terminal.
constexpr std::size_t kPage = 100;

std::size_t Width(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::size_t LongestWord(const std::string& cell) {
  std::size_t longest = 0;
  for (std::size_t begin = 0; begin < cell.size();) {
    const std::size_t end = std::min(cell.find(' ', begin), cell.size());
    longest = std::max(longest, Width(cell.substr(begin, end - begin)));
    begin = end + 1;
  }
  return longest + std::min(cell.find_first_not_of(' '), cell.size());
}

/// The lines of a cell in `width` columns: broken at spaces, with the indent of the first line.
std::vector<std::string> LinesOf(const std::string& cell, std::size_t width) {
  if (Width(cell) <= width) return {cell};
  const std::size_t indent = std::min(cell.find_first_not_of(' '), width / 2);
  std::vector<std::string> lines;
  const std::string wrapped = Wrapped(cell, indent, width);
  for (std::size_t begin = 0; begin < wrapped.size();) {
    const std::size_t end = wrapped.find('\n', begin);
    lines.push_back(wrapped.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

}  // namespace

void Table::AddColumn(std::string head, bool right, std::string group) {
  columns_.push_back({std::move(head), right, std::move(group)});
}

void Table::AddRow(std::vector<std::string> cells) {
  cells.resize(columns_.size());
  rows_.push_back(std::move(cells));
}

std::vector<std::size_t> Table::Widths() const {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    std::size_t width = Width(columns_[c].head);
    for (const auto& row : rows_) width = std::max(width, Width(row[c]));
    widths.push_back(width);
  }
  return widths;
}

Table Table::NoWiderThan(std::size_t screen) const {
  std::vector<std::size_t> widths = Widths(), least;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    least.push_back(LongestWord(columns_[c].head));
    for (const auto& row : rows_) least[c] = std::max(least[c], LongestWord(row[c]));
  }
  std::size_t all = std::accumulate(widths.begin(), widths.end(), 2 * widths.size());
  for (; all > screen; --all) {
    std::size_t widest = widths.size();
    for (std::size_t c = 0; c < widths.size(); ++c)
      if (widths[c] > least[c] && (widest == widths.size() || widths[c] > widths[widest]))
        widest = c;
    if (widest == widths.size()) break;
    --widths[widest];
  }
  Table table(keys_);
  table.is_whole_ = true;
  table.columns_ = columns_;
  for (const auto& row : rows_) {
    std::vector<std::vector<std::string>> cells;
    std::size_t height = 1;
    for (std::size_t c = 0; c < row.size(); ++c) {
      cells.push_back(LinesOf(row[c], widths[c]));
      height = std::max(height, cells.back().size());
    }
    for (std::size_t line = 0; line < height; ++line) {
      std::vector<std::string> part;
      for (const auto& cell : cells) part.push_back(line < cell.size() ? cell[line] : "");
      table.rows_.push_back(std::move(part));
    }
  }
  return table;
}

std::string Table::Text() const {
  if (is_whole_) {
    const std::size_t screen = TerminalWidth();
    const Table table = NoWiderThan(screen > 0 ? screen : kPage);
    return table.TextOf(table.Widths());
  }
  return TextOf(Widths());
}

std::string Table::TextOf(const std::vector<std::size_t>& widths) const {
  const std::size_t screen = is_whole_ ? 0 : TerminalWidth();
  std::vector<std::size_t> keys;
  std::size_t keys_width = 0;
  for (std::size_t c = 0; c < std::min(keys_, columns_.size()); ++c) {
    keys.push_back(c);
    keys_width += widths[c] + 2;
  }
  std::vector<std::vector<std::size_t>> parts = {keys};
  std::size_t width = keys_width;
  for (std::size_t c = keys.size(); c < columns_.size(); ++c) {
    const bool is_full = screen > 0 && width + widths[c] + 2 > screen;
    if (is_full && parts.back().size() > keys.size()) {
      parts.push_back(keys);
      width = keys_width;
    }
    parts.back().push_back(c);
    width += widths[c] + 2;
  }
  std::string text;
  for (const auto& part : parts) text += (text.empty() ? "" : "\n") + PartText(widths, part);
  return text;
}

/// Each group centred above its columns, or beginning with them if it is wider.
std::string Table::GroupLine(const std::vector<std::size_t>& widths,
                             const std::vector<std::size_t>& columns) const {
  std::string line;
  std::size_t at = 0, used = 0;
  for (std::size_t i = 0; i < columns.size();) {
    const std::string& group = columns_[columns[i]].group;
    std::size_t span = 0;
    for (; i < columns.size() && columns_[columns[i]].group == group; ++i)
      span += widths[columns[i]] + 2;
    if (!group.empty()) {
      const std::size_t size = Width(group), room = span - 2;
      const std::size_t begin = std::max(at + 2 + (room > size ? (room - size) / 2 : 0), used + 2);
      line += std::string(begin - used, ' ') + group;
      used = begin + size;
    }
    at += span;
  }
  return line.empty() ? line : line + '\n';
}

std::string Table::PartText(const std::vector<std::size_t>& widths,
                            const std::vector<std::size_t>& columns) const {
  std::string text = GroupLine(widths, columns);
  const auto add_line = [&](auto cell_of) {
    std::string line;
    for (const std::size_t c : columns) {
      const std::string cell = cell_of(c);
      const std::string padding(widths[c] - Width(cell), ' ');
      line += "  ";
      line += columns_[c].right ? padding + cell : cell + padding;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  };
  add_line([&](std::size_t c) { return columns_[c].head; });
  std::size_t total = 0;
  for (const std::size_t c : columns) total += widths[c] + 2;
  text += "  " + std::string(total > 2 ? total - 2 : 0, '-') + '\n';
  for (const auto& row : rows_) add_line([&](std::size_t c) { return row[c]; });
  return text;
}

std::string GridText(const std::vector<plan::Axis>& axes, std::uint64_t repeats) {
  std::string text;
  for (const plan::Axis& axis : axes)
    text += text.empty() ? fmt::format("{} value{} of {}", axis.values.size(),
                                       axis.values.size() == 1 ? "" : "s", axis.name)
                         : fmt::format(" x {} of {}", axis.values.size(), axis.name);
  if (repeats > 1) text += fmt::format("{}{} repeats", text.empty() ? "" : " x ", repeats);
  return text;
}

std::string CoordinateText(const plan::Axis& axis, std::size_t index) {
  return plan::CoordinateLabel(axis, index);
}

std::string ShortNumber(double value) {
  if (!std::isfinite(value)) return "-";
  if (value == 0) return "0";
  const double size = std::fabs(value);
  if (size < 1e-4 || size >= 1e7) return fmt::format("{:.2e}", value);
  // Rounded first, so that 9.996 becomes 10.0, and 12346 becomes 12350.
  const double rounded = std::stod(fmt::format("{:.{}e}", value, size < 1000 ? 2 : 3));
  const int exponent = static_cast<int>(std::floor(std::log10(std::fabs(rounded))));
  return fmt::format("{:.{}f}", rounded, std::clamp(2 - exponent, 0, 9));
}

}  // namespace cdb::terminal
