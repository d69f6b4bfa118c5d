#include "compiler/plan/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <utility>

#include "compiler/schema/parametrised_words.h"
#include "dsl/text/utf8.h"

// The fields are split here and not by Debian's libcsv, which knows neither comments, runs of
// spaces, the lines of its rows nor whether a field was quoted.

namespace cdb::plan {
namespace {

using text::Printable;

constexpr std::string_view kSeparators = "\t;, ";

struct SeparatorName {
  char separator;
  std::string_view word, noun;
};
constexpr SeparatorName kSeparatorNames[] = {{',', "comma", "commas"},
                                             {';', "semicolon", "semicolons"},
                                             {'\t', "tab", "tabs"},
                                             {' ', "spaces", "spaces"}};

const SeparatorName& NameOf(char separator) {
  return *std::ranges::find(kSeparatorNames, separator, &SeparatorName::separator);
}

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return text;
}

std::string Plural(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// Removes the digits at the beginning; their number.
std::size_t TakeDigits(std::string_view& text) {
  std::size_t count = 0;
  while (count < text.size() && text::IsDigit(text[count])) ++count;
  text.remove_prefix(count);
  return count;
}

/// `-1.5e3`, with digits on both sides of a decimal comma; `nan` and `inf`, which are refused when
/// they are read.
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

bool HasDecimalComma(std::string_view text) {
  return text.find(',') != text.npos && IsNumber(text, ',');
}

/// `1,234` may be a thousand; `0,123`, `1,5` and `1,2345` may not.
bool MayBeThousands(std::string_view text) {
  if (text.starts_with('+') || text.starts_with('-')) text.remove_prefix(1);
  const std::size_t comma = text.find(',');
  return comma >= 1 && comma <= 3 && text.size() == comma + 4 && text[0] != '0';
}

std::string_view WordArgument(const schema::Call& call, std::string_view name) {
  const schema::Word* word = AsWord(schema::ArgumentOf(call, name));
  return word != nullptr ? std::string_view(word->text) : std::string_view();
}

void Replace(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size())
    text.replace(at, from.size(), to);
}

/// The unit written in a heading: `mm`, `Seconds`, `m s^-1`, `°/s`; nullopt if it is not known.
std::optional<text::Unit> UnitOf(std::string_view written) {
  std::string name(Trimmed(written));
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

Dialect DialectOf(const schema::Call& call) {
  Dialect dialect;
  for (const SeparatorName& row : kSeparatorNames)
    if (WordArgument(call, "separator") == row.word) dialect.separator = row.separator;
  const std::string_view decimal = WordArgument(call, "decimal");
  if (decimal != "auto") dialect.decimal = decimal == "comma" ? ',' : '.';
  if (const auto* number = schema::AsNumber(schema::ArgumentOf(call, "header")))
    dialect.header = static_cast<std::size_t>(number->AsCount());
  if (WordArgument(call, "header") == "none") dialect.header = Dialect::kNoHeader;
  return dialect;
}

ColumnName ParseColumnName(std::string_view text) {
  text = Trimmed(text);
  const char close = text.empty() ? '\0' : text.back();
  const std::size_t open = close == ']'   ? text.rfind('[')
                           : close == ')' ? text.rfind('(')
                                          : std::string_view::npos;
  if (open == text.npos || open == 0) return {std::string(text), {}, {}};
  const std::string_view unit = Trimmed(text.substr(open + 1, text.size() - open - 2));
  return {std::string(Trimmed(text.substr(0, open))), std::string(unit.empty() ? "-" : unit),
          UnitOf(unit)};
}

double InSi(double value, const text::Unit& unit) {
  value = value * unit.factor / unit.divisor;
  for (int i = 0; i < unit.pis; ++i) value *= std::numbers::pi;
  // Powers of ten up to 22 are exact, so that dividing rounds once.
  const double power = std::pow(10.0, std::abs(unit.tens));
  return unit.tens < 0 ? value / power : value * power;
}

TextTable::TextTable(std::string_view text, std::string name, const Dialect& dialect)
    : text_(text), name_(std::move(name)), dialect_(dialect) {
  if (text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF") ||
      text_.find('\0') != text_.npos)
    throw TableError(fmt::format("{}: it is not text in UTF-8", name_), "save it as CSV in UTF-8");
  if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
  Line line{1, 0};
  ReadSeparatorLine(line);
  const std::size_t header = dialect_.header.value_or(Dialect::kNoHeader);
  while (line.number < header && line.begin < text_.size()) {
    LineAt(line.begin, line.begin);
    ++line.number;
  }
  if (header > 0 && line.begin >= text_.size())
    throw TableError(fmt::format("{}: it has no line {}", name_, header),
                     "name the line of the headings");
  // A comment of headings is found as the one above the numbers.
  std::size_t next = 0;
  if (header > 0 && Trimmed(LineAt(line.begin, next)).starts_with('#')) dialect_.header.reset();
  if (!SkipToContent(line)) return;
  FindForm(line);
  ReadRows(line);
}

std::string TextTable::Place(std::size_t row) const {
  return fmt::format("{}:{}", name_, lines_[row]);
}

std::string TextTable::PlaceOfHeadings() const {
  return heading_line_ == 0 ? name_ : fmt::format("{}:{}", name_, heading_line_);
}

void TextTable::Refuse(std::size_t line, const std::string& cause,
                       const std::string& remedy) const {
  throw TableError(fmt::format("{}:{}: {}", name_, line, cause), remedy);
}

std::string_view TextTable::LineAt(std::size_t at, std::size_t& next) const {
  const std::size_t end = std::min(text_.find('\n', at), text_.size());
  next = std::min(end + 1, text_.size());
  return text_.substr(at, end - at);
}

bool TextTable::SkipToContent(Line& line) {
  while (line.begin < text_.size()) {
    std::size_t next = 0;
    const std::string_view content = Trimmed(LineAt(line.begin, next));
    if (!content.empty() && content.front() != '#') return true;
    if (!content.empty()) comment_ = content.substr(1);
    line = {line.number + 1, next};
  }
  return false;
}

void TextTable::Split(Line& line, char separator, bool is_data, std::vector<Field>& fields) {
  fields.clear();
  const std::size_t first = line.number, size = text_.size();
  const bool has_comments = is_data && dialect_.has_trailing_comments;
  const auto ends_field = [&](char c) {
    return c == '\n' || (separator != 0 && c == separator) || (separator == ' ' && c == '\t') ||
           (has_comments && c == '#');
  };
  std::size_t at = line.begin;
  const auto skip_blanks = [&] {
    while (at < size && IsBlank(text_[at]) && text_[at] != (separator == '\t' ? '\t' : '\0')) ++at;
  };
  for (;;) {
    skip_blanks();
    if (separator == ' ' && !fields.empty() && (at >= size || ends_field(text_[at]))) break;
    Field field;
    if (at < size && text_[at] == '"') {
      const std::size_t begin = ++at;
      bool is_doubled = false;
      for (;; ++at) {
        if (at >= size)
          Refuse(first, "a quoted field does not end",
                 "write the second quote, or remove the first");
        if (text_[at] == '\n') ++line.number;
        if (text_[at] != '"') continue;
        if (at + 1 >= size || text_[at + 1] != '"') break;
        is_doubled = true;
        ++at;
      }
      field = {Trimmed(text_.substr(begin, at - begin)), true};
      if (is_doubled) {
        std::string& plain = unquoted_.emplace_back(field.text);
        Replace(plain, "\"\"", "\"");
        field.text = plain;
      }
      ++at;
      skip_blanks();
      if (separator != ' ' && at < size && !ends_field(text_[at]))
        Refuse(first, "text follows a quoted field",
               "put the whole field into quotes, with \"\" for a quote in it");
    } else {
      const std::size_t begin = at;
      while (at < size && !ends_field(text_[at])) ++at;
      field.text = Trimmed(text_.substr(begin, at - begin));
    }
    fields.push_back(field);
    if (at >= size || text_[at] == '\n' || text_[at] == '#') break;
    if (separator != ' ') ++at;
  }
  LineAt(at, line.begin);
  ++line.number;
}

std::vector<TextTable::Field> TextTable::FieldsAt(Line line, char separator, bool is_data) {
  std::vector<Field> fields;
  Split(line, separator, is_data, fields);
  return fields;
}

void TextTable::ReadSeparatorLine(Line& line) {
  std::size_t next = 0;
  std::string_view first = Trimmed(LineAt(0, next));
  if (first.size() >= 2 && first.front() == '"' && first.back() == '"')
    first = first.substr(1, first.size() - 2);
  // A tab at the end is trimmed.
  if (!first.starts_with("sep=") || first.size() > 5) return;
  const char separator = first.size() == 4 ? '\t' : first[4];
  line = {2, next};
  if (dialect_.separator != 0) return;
  if (kSeparators.find(separator) == kSeparators.npos)
    Refuse(1, fmt::format("`{}` cannot separate columns", Printable(first.substr(4))),
           "the separators are comma, semicolon, tab and spaces");
  dialect_.separator = separator;
}

bool TextTable::IsNumeric(Line line, char separator, char decimal) {
  const auto fields = FieldsAt(line, separator, true);
  return std::ranges::all_of(fields,
                             [&](const Field& field) {
                               return field.text.empty() || IsNumber(field.text, decimal);
                             }) &&
         std::ranges::any_of(fields, [](const Field& field) { return !field.text.empty(); });
}

// A number contains neither tabs, semicolons nor spaces, so that only a comma has two meanings.
bool TextTable::FindFormOfNumbers(const Line& line) {
  const auto is_numeric = [&](char separator) {
    try {
      return (dialect_.decimal != ',' && IsNumeric(line, separator, '.')) ||
             (dialect_.decimal != '.' && IsNumeric(line, separator, ','));
    } catch (const TableError&) {
      return false;  // text after a quote: another separator
    }
  };
  if (dialect_.separator != 0) return is_numeric(dialect_.separator);
  const bool is_one = is_numeric(0);
  for (const char separator : kSeparators) {
    if (separator == ',' && dialect_.decimal == ',') continue;
    if (!is_numeric(separator) || FieldsAt(line, separator, true).size() < 2) continue;
    if (is_one && separator == ',' && MayHaveDecimalCommas(line))
      RefuseLoneComma(line.number, FieldsAt(line, 0, true)[0].text);
    dialect_.separator = separator;
    return true;
  }
  return is_one;
}

/// True if each line is one number with a decimal comma, or without one.
bool TextTable::MayHaveDecimalCommas(Line line) {
  std::vector<Field> fields;
  try {
    while (SkipToContent(line)) {
      Split(line, 0, true, fields);
      if (!fields[0].text.empty() && !IsNumber(fields[0].text, ',')) return false;
    }
    return true;
  } catch (const TableError&) {
    return false;  // text after a quote
  }
}

void TextTable::RefuseLoneComma(std::size_t line, std::string_view example) const {
  Refuse(line,
         fmt::format("`{}` may be one number with a decimal comma, or two numbers",
                     Printable(example)),
         "name the sign between the columns or the decimal sign: separator: comma, or decimal: "
         "comma");
}

void TextTable::FindFormOfHeadings(const Line& line) {
  if (dialect_.separator != 0) return;
  bool is_quoted = false;
  std::string found;
  Line after = line;
  for (; after.begin < text_.size(); ++after.begin) {
    const char c = text_[after.begin];
    if (c == '\n') ++after.number;
    if (c == '\n' && !is_quoted) break;
    if (c == '"') is_quoted = !is_quoted;
    if (is_quoted || c == ' ' || (c == ',' && dialect_.decimal == ',')) continue;
    if (kSeparators.find(c) != kSeparators.npos && found.find(c) == found.npos) found += c;
  }
  after.begin = std::min(after.begin + 1, text_.size());
  const bool has_rows = SkipToContent(after);
  if (found.empty()) {
    // Spaces separate the columns if they do so in the numbers; otherwise they belong to a name.
    const bool are_spaces = FieldsAt(line, ' ', false).size() > 1 && has_rows &&
                            FieldsAt(after, ' ', true).size() > 1 && FindFormOfNumbers(after) &&
                            dialect_.separator == ' ';
    dialect_.separator = are_spaces ? ' ' : '\0';
    return;
  }
  if (found.size() > 1) {
    std::string fitting;
    for (const char separator : found) try {
        if (has_rows &&
            FieldsAt(line, separator, false).size() == FieldsAt(after, separator, true).size())
          fitting += separator;
      } catch (const TableError&) {  // text after a quote: another separator
      }
    if (fitting.size() != 1)
      Refuse(line.number,
             fmt::format("{} and {} may separate the columns", NameOf(found[0]).noun,
                         NameOf(found[1]).noun),
             fmt::format("name one: separator: {}", NameOf(found[0]).word));
    found = fitting;
  }
  dialect_.separator = found[0];
}

void TextTable::CheckHeadings(const std::vector<Field>& fields, const Line& line) {
  if (dialect_.header) return;
  const auto is_number = [](const Field& field) {
    return !field.text.empty() && (IsNumber(field.text, '.') || IsNumber(field.text, ','));
  };
  if (std::ranges::none_of(fields, is_number)) return;
  // Probably the line above the first one with nothing but numbers.
  Line at = line, above = line;
  std::string where = "4";
  std::vector<Field> rest;
  while (SkipToContent(at)) {
    if (IsNumeric(at, dialect_.separator, '.') || IsNumeric(at, dialect_.separator, ',')) {
      where = fmt::format("{}", above.number);
      break;
    }
    above = at;
    Split(at, dialect_.separator, true, rest);
  }
  Refuse(line.number, "it has words and numbers, so it may be headings or values",
         fmt::format("name the line of the headings, such as header: {}, or write header: none",
                     where));
}

void TextTable::FindForm(Line& line) {
  const bool is_named = dialect_.header.value_or(Dialect::kNoHeader) > 0;
  const bool has_numbers = !is_named && FindFormOfNumbers(line);
  if (!has_numbers) FindFormOfHeadings(line);
  if (!has_numbers && dialect_.header != Dialect::kNoHeader) {
    ReadHeadings(line);
    ReadUnits(line);
    return;
  }
  width_ = FieldsAt(line, dialect_.separator, true).size();
  if (comment_.empty()) return;
  // A view of the text, so that its line can be split like others.
  const auto begin = static_cast<std::size_t>(comment_.data() - text_.data());
  const auto fields = FieldsAt({line.number, begin}, dialect_.separator, false);
  if (fields.size() != width_) return;
  for (const Field& field : fields) headings_.emplace_back(field.text);
}

void TextTable::ReadHeadings(Line& line) {
  heading_line_ = line.number;
  std::vector<Field> fields;
  const Line begin = line;
  Split(line, dialect_.separator, false, fields);
  CheckHeadings(fields, begin);
  for (const Field& field : fields) headings_.emplace_back(field.text);
  width_ = fields.size();
}

void TextTable::ReadUnits(Line& line) {
  Line at = line;
  if (!SkipToContent(at)) return;
  std::vector<Field> fields;
  Split(at, dialect_.separator, false, fields);
  const auto is_unit = [](const Field& field) { return UnitOf(field.text).has_value(); };
  const auto is_empty = [](const Field& field) { return field.text.empty(); };
  if (fields.size() != width_ || !std::ranges::all_of(fields, is_unit) ||
      std::ranges::all_of(fields, is_empty) ||
      std::ranges::any_of(fields, [](const Field& field) { return IsNumber(field.text, '.'); }))
    return;
  for (const Field& field : fields) units_.emplace_back(field.text);
  line = at;
}

void TextTable::ReadRows(Line line) {
  std::vector<Field> fields;
  while (SkipToContent(line)) {
    const std::size_t number = line.number;
    Split(line, dialect_.separator, true, fields);
    // Spreadsheets write empty rows as separators alone.
    const bool is_empty =
        std::ranges::all_of(fields, [](const Field& field) { return field.text.empty(); });
    if (is_empty && (width_ > 1 || fields.size() == 1)) continue;
    if (fields.size() != width_)
      Refuse(number,
             fmt::format("{} in this line, but {}", Plural(fields.size(), "value"),
                         Plural(width_, "column")),
             lines_.empty() && heading_line_ > 0
                 ? fmt::format("write a value for each column; if line {} is not the headings, "
                               "name their line: header: {}",
                               heading_line_, std::max(number, std::size_t{2}) - 1)
                 : "write a value for each column");
    cells_.insert(cells_.end(), fields.begin(), fields.end());
    lines_.push_back(number);
  }
}

Column TextTable::At(std::size_t index) const {
  if (index >= headings_.size()) return {index, fmt::format("#{}", index + 1), std::nullopt};
  const std::string& heading = headings_[index];
  const ColumnName name = ParseColumnName(heading);
  const bool has_row_unit = index < units_.size() && !units_[index].empty();
  if (name.unit_text.empty() && has_row_unit) return {index, heading, UnitOf(units_[index])};
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
  written = Trimmed(written);
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
  const auto of_file = has_row_unit                ? UnitOf(units_[*found])
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
