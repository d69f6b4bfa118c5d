// The columns of a table: their names, units and numbers.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <utility>

#include "compiler/plan/text_table.h"
#include "dsl/text/utf8.h"

namespace cdb::plan {
namespace {

using text::Printable;

/// Removes the digits at the beginning; their number.
std::size_t TakeDigits(std::string_view& text) {
  std::size_t count = 0;
  while (count < text.size() && text::IsDigit(text[count])) ++count;
  text.remove_prefix(count);
  return count;
}

bool HasDecimalComma(std::string_view text) {
  return text.find(',') != text.npos && IsNumber(text, ',');
}

/// `1,234` may be a thousand; `0,123`, `1,5` and `1,2345` may not.
bool MayBeThousands(std::string_view text) {
  if (text.starts_with('+') || text.starts_with('-')) text.remove_prefix(1);
  const std::size_t comma = text.find(',');
  return comma >= 1 && comma <= 3 && text.size() == comma + 4 && text[0] != '0';
}

void Replace(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size())
    text.replace(at, from.size(), to);
}

bool IsSame(const text::Unit& a, const text::Unit& b) {
  return a.HasDimensionOf(b) && InSi(1, a) == InSi(1, b);
}

/// The unit at the end of a heading such as `size_mm`, which may be part of its name; empty if
/// there is none.
std::string_view UnitSuffix(std::string_view heading) {
  const std::size_t at = heading.rfind('_');
  if (at == heading.npos || at == 0) return {};
  const std::string_view suffix = heading.substr(at + 1);
  for (const std::string_view unit : {"km", "cm", "mm", "um", "ms", "us", "ns", "min", "deg"})
    if (suffix == unit) return suffix;
  return {};
}

}  // namespace

std::string_view TrimmedField(std::string_view text) {
  while (!text.empty() && IsBlankInField(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlankInField(text.back())) text.remove_suffix(1);
  return text;
}

bool IsNumber(std::string_view text, char decimal) {
  if (text.starts_with('+') || text.starts_with('-')) text.remove_prefix(1);
  for (const std::string_view word : {"nan", "NaN", "NAN", "inf", "Inf", "INF"})
    if (text == word) return true;
  const std::size_t before = TakeDigits(text);
  std::size_t after = 0;
  if (text.starts_with(decimal)) {
    text.remove_prefix(1);
    after = TakeDigits(text);
    if (decimal == ',' && (before == 0 || after == 0)) return false;
  }
  if (before + after == 0) return false;
  if (text.empty()) return true;
  if (text[0] != 'e' && text[0] != 'E') return false;
  text.remove_prefix(1);
  if (text.starts_with('+') || text.starts_with('-')) text.remove_prefix(1);
  return TakeDigits(text) > 0 && text.empty();
}

std::optional<text::Unit> UnitNamed(std::string_view written) {
  std::string name(TrimmedField(written));
  if (name.empty() || name == "-" || name == "1") return text::Unit{};
  Replace(name, "\xC2\xB5", "u");    // µ, micro sign
  Replace(name, "\xCE\xBC", "u");    // μ, Greek letter
  Replace(name, "\xC2\xB0", "deg");  // °
  Replace(name, "\xC2\xB2", "^2");   // ²
  Replace(name, " s^-1", "/s");
  Replace(name, " s-1", "/s");
  Replace(name, " s^-2", "/s^2");
  Replace(name, " s-2", "/s^2");
  if (const auto unit = text::ParseUnit(name)) return unit;
  for (char& c : name)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  const std::string_view meant = text::UnitCalled(name);
  return meant.empty() ? std::nullopt : text::ParseUnit(meant);
}

ColumnName ParseColumnName(std::string_view text) {
  text = TrimmedField(text);
  const char close = text.empty() ? '\0' : text.back();
  const std::size_t open = close == ']'   ? text.rfind('[')
                           : close == ')' ? text.rfind('(')
                                          : std::string_view::npos;
  if (open == text.npos || open == 0) return {std::string(text), {}, {}};
  const std::string_view unit = TrimmedField(text.substr(open + 1, text.size() - open - 2));
  return {std::string(TrimmedField(text.substr(0, open))), std::string(unit.empty() ? "-" : unit),
          UnitNamed(unit)};
}

double InSi(double value, const text::Unit& unit) {
  value = value * unit.factor / unit.divisor;
  for (int i = 0; i < unit.pis; ++i) value *= std::numbers::pi;
  // Powers of ten up to 22 are exact, so that dividing rounds once.
  const double power = std::pow(10.0, std::abs(unit.tens));
  return unit.tens < 0 ? value / power : value * power;
}

Column TextTable::At(std::size_t index) const {
  if (index >= headings_.size()) return {index, fmt::format("#{}", index + 1), std::nullopt};
  const std::string& heading = headings_[index];
  const ColumnName name = ParseColumnName(heading);
  const bool has_row_unit = index < units_.size() && !units_[index].empty();
  if (name.unit_text.empty() && has_row_unit) return {index, heading, UnitNamed(units_[index])};
  if (!name.unit_text.empty() && !name.unit)
    throw TableError(fmt::format("{}: `{}` in the heading `{}` is not a known unit",
                                 PlaceOfHeadings(), Printable(name.unit_text), Printable(heading)),
                     fmt::format("write the unit after the name: \"{} [m]\"", Printable(heading)));
  if (const std::string_view unit = UnitSuffix(heading); name.unit_text.empty() && !unit.empty())
    throw TableError(
        fmt::format("{}: the column `{}` may be in {}", PlaceOfHeadings(), heading, unit),
        fmt::format("write its unit after the name: \"{} [{}]\"", heading, unit));
  return {index, heading, name.unit};
}

Column TextTable::Find(std::string_view written) const {
  written = TrimmedField(written);
  const auto find = [&](std::string_view name, auto&& of) {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < headings_.size(); ++i) {
      if (name.empty() || of(headings_[i]) != name) continue;
      if (found)
        throw TableError(fmt::format("{}: the heading `{}` occurs twice, as #{} and #{}",
                                     PlaceOfHeadings(), Printable(name), *found + 1, i + 1),
                         fmt::format("name the column by its number: \"#{}\"", *found + 1));
      found = i;
    }
    return found;
  };
  const auto whole = [](const std::string& heading) -> std::string { return heading; };
  const auto stem = [](const std::string& heading) { return ParseColumnName(heading).stem; };
  if (const auto exact = find(written, whole)) return At(*exact);
  const ColumnName name = ParseColumnName(written);
  if (!name.unit_text.empty() && !name.unit)
    throw TableError(fmt::format("{}: `{}` is not a known unit", name_, Printable(name.unit_text)),
                     fmt::format("the units are {}", text::UnitNames()));
  auto found = find(name.stem, whole);
  if (!found) found = find(name.stem, stem);
  std::size_t number = 0;
  const std::string_view digits = std::string_view(name.stem).substr(name.stem.empty() ? 0 : 1);
  const char* end = digits.data() + digits.size();
  if (!found && name.stem.starts_with('#') &&
      std::from_chars(digits.data(), end, number).ptr == end && number >= 1 && number <= width_)
    found = number - 1;
  // `#timestamp [ns]`, as the comment of headings shows it.
  if (!found && written.starts_with('#') && number == 0 && !headings_.empty())
    return Find(written.substr(1));
  if (!found)
    throw TableError(
        fmt::format("{}: it has no column `{}`", PlaceOfHeadings(), Printable(name.stem)),
        width_ == 0 ? "it is empty" : "its columns are " + ColumnList());
  if (name.unit_text.empty()) return At(*found);
  const bool has_row_unit = *found < units_.size() && !units_[*found].empty();
  const auto of_file = has_row_unit                ? UnitNamed(units_[*found])
                       : *found < headings_.size() ? ParseColumnName(headings_[*found]).unit
                                                   : std::nullopt;
  if (of_file && !IsSame(*of_file, *name.unit))
    throw TableError(
        fmt::format("{}: the column `{}` has another unit in the file than {}", PlaceOfHeadings(),
                    Printable(headings_[*found]), Printable(name.unit_text)),
        "remove the unit here, or correct the file");
  return {*found, *found < headings_.size() ? headings_[*found] : name.stem, name.unit};
}

bool TextTable::IsEmptyColumn(std::size_t index) const {
  if (!headings_[index].empty()) return false;
  for (std::size_t row = 0; row < rows(); ++row)
    if (!Cell(row, index).empty()) return false;
  return true;
}

void TextTable::FindDecimal(std::span<const Column> columns) {
  if (dialect_.decimal != 0) return;
  dialect_.decimal = '.';
  const Field *with_comma = nullptr, *with_point = nullptr;
  std::size_t comma_row = 0, point_row = 0;
  bool is_proven = false;
  for (std::size_t row = 0; row < rows(); ++row)
    for (const Column& column : columns) {
      const Field& field = cells_[row * width_ + column.index];
      if (HasDecimalComma(field.text)) {
        if (dialect_.separator == 0 && !field.is_quoted) RefuseLoneComma(lines_[row], field.text);
        if (with_comma == nullptr) comma_row = row, with_comma = &field;
        is_proven = is_proven || !MayBeThousands(field.text);
      } else if (with_point == nullptr && field.text.find('.') != std::string_view::npos &&
                 IsNumber(field.text, '.')) {
        point_row = row, with_point = &field;
      }
    }
  if (with_comma == nullptr) return;
  if (with_point != nullptr)
    Refuse(std::max(lines_[comma_row], lines_[point_row]),
           fmt::format("it has numbers with a comma, `{}` in line {}, and with a point, `{}` in "
                       "line {}",
                       with_comma->text, lines_[comma_row], with_point->text, lines_[point_row]),
           "write all numbers alike, without separators of thousands");
  if (!is_proven)
    Refuse(lines_[comma_row],
           fmt::format("`{}` may be a number with a decimal comma, or thousands", with_comma->text),
           "write decimal: comma if it is a decimal comma; otherwise remove the commas");
  dialect_.decimal = ',';
}

double TextTable::Number(std::size_t row, const Column& column) const {
  const std::string_view written = Cell(row, column.index);
  std::string copy;
  std::string_view text = written;
  if (dialect_.decimal == ',' && text.find(',') != text.npos && text.find('.') == text.npos) {
    copy = text;
    std::ranges::replace(copy, ',', '.');
    text = copy;
  } else if (dialect_.decimal == ',' && text.find('.') != text.npos) {
    text = {};
  }
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    Refuse(lines_[row],
           fmt::format("{} is `{}`, which is not a finite number", Printable(column.name),
                       Printable(written)),
           dialect_.decimal == ',' ? "write a number with a decimal comma, such as -1,5 or 2e-3"
                                   : "write a number with a decimal point, such as -1.5 or 2e-3");
  return column.unit ? InSi(value, *column.unit) : value;
}

std::string TextTable::ColumnList() const {
  constexpr std::size_t kMost = 40;
  std::string list;
  for (std::size_t i = 0; i < std::min(width_, kMost); ++i) {
    if (i > 0) list += ", ";
    list += fmt::format("#{}", i + 1);
    if (i < headings_.size() && !headings_[i].empty()) list += " " + Printable(headings_[i]);
  }
  return width_ > kMost ? list + ", …" : list;
}

}  // namespace cdb::plan
