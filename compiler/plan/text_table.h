// Tables of text: CSV as spreadsheets, ROS, motion capture and SLAM tools write it. The one reader
// of poses, paths and measured values.
//
// Recognised, or named by the user: the separator (comma, semicolon, tab or runs of spaces), the
// decimal sign, the line of headings. Also read: quoted fields (RFC 4180), Excel's line `sep=;`, a
// byte order mark, CR LF, comment lines (#), a line of units below the headings, headings in the
// last comment above the numbers (TUM, EuRoC). What could be read in two ways is refused.
//
// Errors: TableError with the file, the line, the cause and the remedy. Threads: any.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/value.h"
#include "dsl/text/units.h"

namespace cdb::plan {

struct TableError : std::runtime_error {
  TableError(const std::string& cause, std::string with)
      : std::runtime_error(cause), remedy(std::move(with)) {}
  std::string remedy;
};

/// The parts of a table's form that the user has named.
struct Dialect {
  static constexpr std::size_t kNoHeader = 0;
  char separator = 0;  ///< `,`, `;`, a tab, or a space for runs of them; 0: to be recognised
  char decimal = 0;    ///< `.` or `,`; 0: to be recognised
  std::optional<std::size_t> header = {};  ///< the line of headings, from 1, or kNoHeader
  bool has_trailing_comments = false;      ///< in a line of numbers, a # begins a comment
};

/// Of a call with the arguments `separator`, `decimal` and `header`.
Dialect DialectOf(const schema::Call& call);

/// The name of a column, with its unit: `x [mm]`, `Time (s)`.
struct ColumnName {
  std::string stem;                ///< `x`
  std::string unit_text;           ///< `mm`; empty if none is written
  std::optional<text::Unit> unit;  ///< nullopt if none is written, or it is not known
};
ColumnName ParseColumnName(std::string_view text);
/// The unit written in a heading: `mm`, `Seconds`, `m s^-1`, `°/s`; nullopt if it is not known.
std::optional<text::Unit> UnitNamed(std::string_view written);
/// `-1.5e3`, with digits on both sides of a decimal comma; `nan` and `inf`, which are refused when
/// they are read.
bool IsNumber(std::string_view text, char decimal);
inline bool IsBlankInField(char c) { return c == ' ' || c == '\t' || c == '\r'; }
std::string_view TrimmedField(std::string_view text);
/// The value in SI units.
double InSi(double value, const text::Unit& unit);

/// A column that is read.
struct Column {
  std::size_t index = 0;
  std::string name;                ///< as in the file, or `#2`
  std::optional<text::Unit> unit;  ///< nullopt: numbers without a unit
};

class TextTable {
 public:
  /// `text` must outlive the table; `name` is that of the file, for messages.
  TextTable(std::string_view text, std::string name, const Dialect& dialect);

  /// Empty if the table has none.
  const std::vector<std::string>& headings() const { return headings_; }
  /// False if the headings are those of a comment.
  bool has_heading_line() const { return heading_line_ > 0; }
  std::size_t width() const { return width_; }
  std::size_t rows() const { return lines_.size(); }
  /// `start.csv:12`, the line of a row, or of the headings.
  std::string Place(std::size_t row) const;
  std::string PlaceOfHeadings() const;

  /// The column of a name that the user has written: a heading with or without its unit, or `#2`;
  /// a unit after it is that of a column without one.
  Column Find(std::string_view written) const;
  /// The column of a heading, with its unit.
  Column At(std::size_t index) const;
  /// True if the column has neither a heading nor values, as spreadsheets leave them at the right.
  bool IsEmptyColumn(std::size_t index) const;
  /// Recognises the decimal sign of these columns. Call it once, before Number.
  void FindDecimal(std::span<const Column> columns);
  /// A finite number, in SI units.
  double Number(std::size_t row, const Column& column) const;
  std::string_view Cell(std::size_t row, std::size_t column) const {
    return cells_[row * width_ + column].text;
  }
  /// `if the headings are in line 7, write header: 7`, if another line looks like them, or nothing.
  std::string HeaderAdvice();
  /// `#1 t, #2 x`, for messages.
  std::string ColumnList() const;

 private:
  struct Field {
    std::string_view text;
    bool is_quoted = false;
  };
  struct Line {
    std::size_t number = 0;  ///< from 1
    std::size_t begin = 0;   ///< in text_
  };

  [[noreturn]] void Refuse(std::size_t line, const std::string& cause,
                           const std::string& remedy) const;
  /// The line of text at `at`, and the beginning of the next one.
  std::string_view LineAt(std::size_t at, std::size_t& next) const;
  /// The next line with content at or after `line`; false at the end. Remembers the last comment.
  bool SkipToContent(Line& line);
  /// Splits the fields of the record that begins at `line`, and moves it to the next one.
  void Split(Line& line, char separator, bool is_data, std::vector<Field>& fields);
  std::vector<Field> FieldsAt(Line line, char separator, bool is_data);

  void ReadSeparatorLine(Line& line);
  void FindForm(Line& line);
  bool IsNumeric(Line line, char separator, char decimal);
  bool FindFormOfNumbers(const Line& line);
  void FindFormOfHeadings(const Line& line);
  bool MayHaveDecimalCommas(Line line);
  void CheckHeadings(const std::vector<Field>& fields, const Line& line);
  /// The line above the first one of three numbers or more, from `line` on; 0 if there is none.
  std::size_t LikelyHeader(Line line);
  [[noreturn]] void RefuseLoneComma(std::size_t line, std::string_view example) const;
  void ReadHeadings(Line& line);
  void ReadUnits(Line& line);
  void ReadRows(Line line);

  std::string_view text_;
  std::string name_;
  Dialect dialect_;
  std::string_view comment_;  ///< the last one above the numbers
  std::vector<std::string> headings_;
  std::vector<std::string> units_;  ///< of a line of units
  std::size_t heading_line_ = 0;
  std::size_t width_ = 0;
  std::vector<Field> cells_;
  std::vector<std::size_t> lines_;    ///< of the rows
  std::deque<std::string> unquoted_;  ///< fields with doubled quotes
};

}  // namespace cdb::plan
