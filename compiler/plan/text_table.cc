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

std::string Plural(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string_view WordArgument(const schema::Call& call, std::string_view name) {
  const schema::Word* word = AsWord(schema::ArgumentOf(call, name));
  return word != nullptr ? std::string_view(word->text) : std::string_view();
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
  if (header > 0 && TrimmedField(LineAt(line.begin, next)).starts_with('#'))
    dialect_.header.reset();
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
    const std::string_view content = TrimmedField(LineAt(line.begin, next));
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
    while (at < size && IsBlankInField(text_[at]) && text_[at] != (separator == '\t' ? '\t' : '\0'))
      ++at;
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
      field = {TrimmedField(text_.substr(begin, at - begin)), true};
      if (is_doubled) {
        std::string& plain = unquoted_.emplace_back(field.text);
        for (std::size_t quote = 0; (quote = plain.find("\"\"", quote)) != plain.npos; ++quote)
          plain.erase(quote, 1);
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
      field.text = TrimmedField(text_.substr(begin, at - begin));
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
  std::string_view first = TrimmedField(LineAt(0, next));
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
  const std::size_t likely = LikelyHeader(line);
  Refuse(line.number, "it has words and numbers, so it may be headings or values",
         fmt::format("name the line of the headings{}, or write header: none",
                     likely > line.number ? fmt::format(": header: {}", likely)
                                          : std::string(", such as header: 4")));
}

std::size_t TextTable::LikelyHeader(Line line) {
  const auto fields_at = [&](Line at, char separator) {
    try {
      return FieldsAt(at, separator, true);
    } catch (const TableError&) {
      return std::vector<Field>();
    }
  };
  const auto is_empty = [](const Field& field) { return field.text.empty(); };
  const auto is_unit = [](const Field& field) { return UnitNamed(field.text).has_value(); };
  const auto is_number = [](const Field& field) {
    return field.text.empty() || IsNumber(field.text, '.') || IsNumber(field.text, ',');
  };
  std::vector<Line> above;
  while (SkipToContent(line)) {
    for (const char separator : kSeparators) {
      const auto numbers = fields_at(line, separator);
      if (numbers.size() < 3 || !std::ranges::all_of(numbers, is_number) ||
          std::ranges::all_of(numbers, is_empty))
        continue;
      // A line of units may be between them.
      if (!above.empty() && std::ranges::all_of(fields_at(above.back(), separator), is_unit))
        above.pop_back();
      return above.empty() ? 0 : above.back().number;
    }
    above.push_back(line);
    std::size_t next = 0;
    LineAt(line.begin, next);
    line = {line.number + 1, next};
  }
  return 0;
}

std::string TextTable::HeaderAdvice() {
  const std::size_t likely = LikelyHeader({1, 0});
  return has_heading_line() && likely > heading_line_
             ? fmt::format("if the headings are in line {0}, write header: {0}", likely)
             : std::string();
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
  const auto is_unit = [](const Field& field) { return UnitNamed(field.text).has_value(); };
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
      Refuse(
          number,
          fmt::format("{} in this line, but {}", Plural(fields.size(), "value"),
                      Plural(width_, "column")),
          "write a value for each column" + (HeaderAdvice().empty() ? "" : "; " + HeaderAdvice()));
    cells_.insert(cells_.end(), fields.begin(), fields.end());
    lines_.push_back(number);
  }
}

}  // namespace cdb::plan
