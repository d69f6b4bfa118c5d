#include "runtime/report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cdb::report {
namespace {

std::size_t Width(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

void Table::AddColumn(std::string head, bool right) {
  columns_.push_back({std::move(head), right});
}

void Table::AddRow(std::vector<std::string> cells) {
  cells.resize(columns_.size());
  rows_.push_back(std::move(cells));
}

std::string Table::Text() const {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    std::size_t width = Width(columns_[c].head);
    for (const auto& row : rows_) width = std::max(width, Width(row[c]));
    widths.push_back(width);
  }
  std::string text;
  const auto add_line = [&](auto cell_of) {
    std::string line;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const std::string cell = cell_of(c);
      const std::string padding(widths[c] - Width(cell), ' ');
      line += c == 0 ? "  " : "  ";
      line += columns_[c].right ? padding + cell : cell + padding;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  };
  add_line([&](std::size_t c) { return columns_[c].head; });
  std::size_t total = 0;
  for (const std::size_t width : widths) total += width + 2;
  text += "  " + std::string(total > 2 ? total - 2 : 0, '-') + '\n';
  for (const auto& row : rows_) add_line([&](std::size_t c) { return row[c]; });
  return text;
}

std::string CoordinateText(const plan::Axis& axis, std::size_t index) {
  const plan::Coordinate& value = axis.values[index];
  if (const auto* number = std::get_if<double>(&value)) return schema::FormatReal(*number);
  return std::get<std::string>(value);
}

std::string ShortNumber(double value) {
  if (!std::isfinite(value)) return "-";
  if (value == 0) return "0";
  const int digits = static_cast<int>(std::floor(std::log10(std::fabs(value))));
  std::string text = fmt::format("{:.{}f}", value, std::clamp(2 - digits, 0, 9));
  return text;
}

std::string ScientificNumber(double value) {
  return std::isnan(value) ? "-" : value == 0 ? "0" : fmt::format("{:.2e}", value);
}

}  // namespace cdb::report
