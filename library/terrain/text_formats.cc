// CSV and ESRI ASCII grids.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <utility>

#include "dsl/text/utf8.h"
#include "library/terrain/height_formats.h"
#include "library/terrain/height_grid.h"

namespace cdb::terrain {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

std::string_view WithoutBlanks(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

/// The lines of a text, which end in LF, CR or both.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
  }
  bool Next() {
    if (text_.empty()) return false;
    const std::size_t end = std::min(text_.find_first_of("\r\n"), text_.size());
    line_ = WithoutBlanks(text_.substr(0, end));
    text_.remove_prefix(std::min(end + (text_.substr(end, 2) == "\r\n" ? 2 : 1), text_.size()));
    ++number_;
    return true;
  }
  std::string_view line() const { return line_; }
  std::size_t number() const { return number_; }

 private:
  std::string_view text_, line_;
  std::size_t number_ = 0;
};

/// Of the words of a line, the first one, which is removed.
std::string_view TakeWord(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

class AsciiGridReader {
 public:
  AsciiGridReader(std::string_view bytes, std::string_view name)
      : lines_(bytes), bytes_(bytes.size()), name_(name) {}

  Raster Read() {
    bool is_header = true;
    while (lines_.Next()) {
      std::string_view line = lines_.line();
      if (is_header && IsKey(line)) {
        ReadKey(line);
        continue;
      }
      if (line.empty()) continue;
      if (std::exchange(is_header, false)) EndHeader();
      ReadHeights(line);
    }
    if (is_header) EndHeader();
    if (raster_.heights.size() < cells_)
      RefuseLine(name_, lines_.number(),
                 fmt::format("the file ends after {} of {} by {} heights", raster_.heights.size(),
                             raster_.rows, raster_.columns),
                 "download or export it again");
    FindDegrees();
    return std::move(raster_);
  }

 private:
  enum Key {
    kColumns,
    kRows,
    kX,
    kXCentre,
    kY,
    kYCentre,
    kCell,
    kCellX,
    kCellY,
    kNoDataMark,
    kKeys
  };
  static constexpr std::string_view kNames[kKeys] = {
      "ncols",     "nrows",    "xllcorner", "xllcenter", "yllcorner",
      "yllcenter", "cellsize", "dx",        "dy",        "nodata_value"};

  /// A line of the header begins with a letter; `nan` and `inf` are heights.
  static bool IsKey(std::string_view line) {
    const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
    return !line.empty() && (std::isalpha(static_cast<unsigned char>(line.front())) != 0) &&
           !HeightIn(word);
  }

  void ReadKey(std::string_view line) {
    std::string word(TakeWord(line));
    for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    const auto* const key = std::ranges::find(kNames, word);
    if (key == std::end(kNames))
      Refuse(fmt::format("`{}` is not a key of an ESRI grid", text::Printable(word)),
             "the keys are ncols, nrows, xllcorner, yllcorner, cellsize and NODATA_value");
    std::optional<double>& value = values_[static_cast<std::size_t>(key - std::begin(kNames))];
    if (value) Refuse(fmt::format("{} is there twice", word), "remove one of the lines");
    const std::string_view number = TakeWord(line);
    value = HeightIn(number);
    const bool is_mark = *key == kNames[kNoDataMark];
    if (!value || (!is_mark && !std::isfinite(*value)) || !WithoutBlanks(line).empty())
      Refuse(fmt::format("{} should be a single number", word),
             "download or export the file again");
  }

  void EndHeader() {
    for (const Key key : {kColumns, kRows})
      if (!values_[key])
        Refuse(fmt::format("the header has no {}", kNames[key]),
               "an ESRI grid begins with ncols, nrows, xllcorner, yllcorner and cellsize");
    raster_.columns = Count(kColumns);
    raster_.rows = Count(kRows);
    CheckSize(raster_.columns, raster_.rows, name_);
    cells_ = raster_.columns * raster_.rows;
    raster_.heights.reserve(std::min(cells_, bytes_ / 2));
    const bool has_both = values_[kCellX] && values_[kCellY];
    if (!values_[kCell] && !has_both)
      Refuse("the header has no cellsize, and not both dx and dy", "add `cellsize` and its value");
    if (values_[kCell] && (values_[kCellX] || values_[kCellY]))
      Refuse("the header has cellsize as well as dx or dy", "remove one of them");
    raster_.cell = {values_[has_both ? kCellX : kCell].value(),
                    values_[has_both ? kCellY : kCell].value()};
    if (!(raster_.cell->minCoeff() > 0))
      Refuse("the size of a cell is not more than 0", "export the file again");
  }

  std::size_t Count(Key key) const {
    const double value = *values_[key];
    if (!(value >= 0 && value <= 1e9) || value != std::floor(value))
      Refuse(fmt::format("{} is {:g}", kNames[key], value), "it counts heights");
    return static_cast<std::size_t>(value);
  }

  void ReadHeights(std::string_view line) {
    for (std::string_view word = TakeWord(line); !word.empty(); word = TakeWord(line)) {
      std::optional<double> height = HeightIn(word);
      if (!height)
        Refuse(fmt::format("`{}` is not a height", text::Printable(word)),
               word.find(',') != word.npos ? "write numbers with a point, separated by blanks"
                                           : "write numbers, separated by blanks");
      if (raster_.heights.size() == cells_)
        Refuse(fmt::format("more than {} by {} heights", raster_.rows, raster_.columns),
               "correct ncols and nrows, or export the file again");
      if (IsMark(*height)) height = kNoData;
      raster_.heights.push_back(*height);
    }
  }

  /// Files may have the mark of single precision with fewer digits than the heights have.
  bool IsMark(double height) const {
    const std::optional<double>& mark = values_[kNoDataMark];
    return mark &&
           (height == *mark || (std::abs(height) > 1e30 && std::abs(height / *mark - 1) < 1e-4));
  }

  /// The format has no unit: a cell that is a tenth of a degree or less within the bounds of the
  /// earth is one if the field would otherwise be higher than long.
  void FindDegrees() {
    const Eigen::Vector2d extent(raster_.cell->x() * static_cast<double>(raster_.columns),
                                 raster_.cell->y() * static_cast<double>(raster_.rows));
    const double x = values_[kX].value_or(values_[kXCentre].value_or(0)),
                 y = values_[kY].value_or(values_[kYCentre].value_or(0));
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double height : raster_.heights)
      if (std::abs(height) < 9999) {  // on the earth; others mark missing ones
        low = std::min(low, height);
        high = std::max(high, height);
      }
    if (raster_.cell->maxCoeff() > 0.1 || std::abs(x) > 360 || std::abs(y) > 90 ||
        !(high - low > extent.maxCoeff()))
      return;
    raster_.is_in_degrees = true;
    raster_.latitude = y + extent.y() / 2;
  }

  [[noreturn]] void Refuse(const std::string& cause, const std::string& remedy) const {
    RefuseLine(name_, std::max<std::size_t>(lines_.number(), 1), cause, remedy);
  }

  Lines lines_;
  const std::size_t bytes_;
  const std::string_view name_;
  std::array<std::optional<double>, kKeys> values_;
  std::size_t cells_ = 0;
  Raster raster_;
};

}  // namespace

Raster ReadCsv(std::string_view bytes, std::string_view name) {
  Raster raster;
  for (Lines lines(bytes); lines.Next();) {
    std::string_view line = lines.line();
    if (line.empty() || line.front() == '#') continue;
    const std::size_t before = raster.heights.size();
    for (std::size_t comma = 0; comma != line.npos;) {
      comma = line.find(',');
      const std::string_view word = WithoutBlanks(line.substr(0, comma));
      const auto height = word.empty() ? kNoData : HeightIn(word);
      if (!height)
        RefuseLine(name, lines.number(), fmt::format("`{}` is not a height", text::Printable(word)),
                   "write numbers, separated by commas");
      raster.heights.push_back(*height);
      line.remove_prefix(comma == line.npos ? line.size() : comma + 1);
    }
    const std::size_t columns = raster.heights.size() - before;
    if (raster.rows == 0) raster.columns = columns;
    if (columns != raster.columns)
      RefuseLine(
          name, lines.number(),
          fmt::format("{} heights in this row, but {} in the first", columns, raster.columns),
          "write as many in each row");
    ++raster.rows;
    if (raster.heights.size() > kMaxHeights) break;
  }
  return raster;
}

Raster ReadAsciiGrid(std::string_view bytes, std::string_view name) {
  return AsciiGridReader(bytes, name).Read();
}

}  // namespace cdb::terrain
