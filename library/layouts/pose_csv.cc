// The CSV files of pose_table.h and path.h.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <span>

#include "compiler/schema/number.h"
#include "dsl/text/utf8.h"
#include "library/layouts/pose_table.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

constexpr std::size_t kColumns = 14;
constexpr std::array<std::string_view, kColumns> kNames = {"x",  "y",  "z",  "qw", "qx", "qy", "qz",
                                                           "vx", "vy", "vz", "wx", "wy", "wz", "t"};
/// The columns of a quantity, which must be present together.
struct Quantity {
  std::size_t first, count;
  std::string_view names;
};
constexpr Quantity kPosition = {0, 3, "x, y, z"}, kOrientation = {3, 4, "qw, qx, qy, qz"},
                   kVelocity = {7, 3, "vx, vy, vz"}, kSpin = {10, 3, "wx, wy, wz"},
                   kTime = {13, 1, "t"};
constexpr Quantity kOfPoses[] = {kPosition, kOrientation, kVelocity, kSpin};
constexpr Quantity kOfPath[] = {kTime, kPosition, kOrientation};

/// A kind of table.
struct Layout {
  std::span<const Quantity> quantities;
  std::string_view header;      ///< with only the required columns
  std::string_view columns;     ///< all, in words
  std::string_view rows, none;  ///< noun for a line, and message if there are none
};
constexpr Layout kPoses = {kOfPoses, "x,y,z",
                           "the columns are x, y, z and optionally qw, qx, qy, qz, vx, vy, vz, wx, "
                           "wy, wz, separated by commas",
                           "object", "it has no objects"};
constexpr Layout kPath = {
    kOfPath, "t,x,y,z",
    "the columns of a path are t, x, y, z and optionally qw, qx, qy, qz, separated by commas",
    "time", "it has no poses"};
constexpr double kLargest = 1e15;  ///< larger numbers are not valid

class CsvReader {
 public:
  CsvReader(std::string_view csv, std::string_view name, const Layout& layout)
      : rest_(csv), name_(name), layout_(layout) {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
  }

  PoseTable Read() {
    if (!NextLine())
      Refuse("it is empty", fmt::format("write a line of column names first: {}", layout_.header));
    ReadHeader();
    PoseTable table;
    table.has_orientation = Has(kOrientation);
    table.has_linear_velocity = Has(kVelocity);
    table.has_angular_velocity = Has(kSpin);
    while (NextLine()) {
      const PoseRow row = ReadRow();
      if (Has(kTime) && !table.rows.empty() && !(row.time > table.rows.back().time))
        Refuse(fmt::format("t is {}, but {} in the line before", schema::FormatReal(row.time),
                           schema::FormatReal(table.rows.back().time)),
               "write the lines in the order of their times");
      table.rows.push_back(row);
    }
    if (table.rows.empty())
      Refuse(std::string(layout_.none), fmt::format("write a line for each {}", layout_.rows));
    return table;
  }

 private:
  [[noreturn]] void Refuse(const std::string& cause, const std::string& remedy) const {
    throw library::SceneError(number_ == 0 ? fmt::format("{}: {}", name_, cause)
                                           : fmt::format("{}:{}: {}", name_, number_, cause),
                              remedy);
  }

  static std::string_view Trimmed(std::string_view text) {
    const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    return text;
  }

  /// False at the end of the text.
  bool NextLine() {
    while (!rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      const std::string_view line = Trimmed(rest_.substr(0, end));
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++number_;
      if (line.empty() || line.front() == '#') continue;
      Split(line);
      return true;
    }
    return false;
  }

  void Split(std::string_view line) {
    cells_.clear();
    while (true) {
      const std::size_t end = std::min(line.find(','), line.size());
      cells_.push_back(Trimmed(line.substr(0, end)));
      if (end == line.size()) return;
      line.remove_prefix(end + 1);
    }
  }

  bool Has(const Quantity& quantity) const { return places_[quantity.first].has_value(); }
  bool Takes(std::size_t column) const {
    return std::ranges::any_of(layout_.quantities, [column](const Quantity& quantity) {
      return column >= quantity.first && column < quantity.first + quantity.count;
    });
  }

  void ReadHeader() {
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const auto column = std::ranges::find(kNames, cells_[i]);
      const auto index = static_cast<std::size_t>(column - kNames.begin());
      if (!Takes(index))
        Refuse(fmt::format("`{}` is not a known column", text::Printable(cells_[i])),
               std::string(layout_.columns));
      auto& place = places_[index];
      if (place) Refuse(fmt::format("the column `{}` occurs twice", *column), "keep one of them");
      place = i;
    }
    for (const Quantity& quantity : layout_.quantities) {
      std::size_t there = 0;
      for (std::size_t i = 0; i < quantity.count; ++i)
        there += places_[quantity.first + i].has_value();
      if (quantity.first == kTime.first && there == 0)
        Refuse("the column t is missing", "a path has times and positions: t,x,y,z");
      if (there != quantity.count && (there > 0 || quantity.first == 0))
        Refuse(
            fmt::format("{} of the columns {} are missing", quantity.count - there, quantity.names),
            quantity.first == 0 ? "a position needs all three" : "give all of them, or none");
    }
    columns_ = cells_.size();
  }

  PoseRow ReadRow() const {
    if (cells_.size() != columns_)
      Refuse(fmt::format("{} value{} in this line, but {} columns", cells_.size(),
                         cells_.size() == 1 ? "" : "s", columns_),
             "write a value for each column, separated by commas");
    const auto vector = [this](const Quantity& quantity) {
      Eigen::Vector3d v = Eigen::Vector3d::Zero();
      if (Has(quantity))
        for (int i = 0; i < 3; ++i) v[i] = Number(quantity.first + static_cast<std::size_t>(i));
      return v;
    };
    PoseRow row;
    if (Has(kTime)) row.time = Number(kTime.first);
    row.position = vector(kPosition);
    row.linear_velocity = vector(kVelocity);
    row.angular_velocity = vector(kSpin);
    if (!Has(kOrientation)) return row;
    const auto turn = UnitQuaternion(Number(3), Number(4), Number(5), Number(6));
    if (!turn)
      Refuse("qw, qx, qy, qz are not a unit quaternion",
             "their squares must add up to 1; 1, 0, 0, 0 is no rotation");
    row.orientation = *turn;
    return row;
  }

  double Number(std::size_t column) const {
    std::string_view text = cells_[*places_[column]];
    const std::string_view written = text;
    if (text.starts_with('+')) text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
      Refuse(fmt::format("{} is `{}`, which is not a finite number", kNames[column],
                         text::Printable(written)),
             "write a number with a decimal point, such as -1.5 or 2e-3");
    if (std::abs(value) > kLargest)
      Refuse(fmt::format("{} is {}, beyond {:g}", kNames[column], written, kLargest),
             "positions, velocities and times are in m, m/s, rad/s and s");
    return value;
  }

  std::string_view rest_;
  const std::string_view name_;
  const Layout& layout_;
  std::size_t number_ = 0;  ///< of the line, from 1
  std::vector<std::string_view> cells_;
  std::array<std::optional<std::size_t>, kColumns> places_;
  std::size_t columns_ = 0;
};

void AddNumbers(std::string& text, std::initializer_list<double> values) {
  for (const double value : values) {
    if (!text.empty() && text.back() != '\n') text += ',';
    text += schema::FormatReal(value);
  }
}

}  // namespace

PoseTable ParsePoseCsv(std::string_view csv, std::string_view name) {
  return CsvReader(csv, name, kPoses).Read();
}

PoseTable ParsePathCsv(std::string_view csv, std::string_view name) {
  return CsvReader(csv, name, kPath).Read();
}

std::optional<Eigen::Quaterniond> UnitQuaternion(double w, double x, double y, double z) {
  constexpr double kOff = 1e-3, kExact = 1e-14;
  const Eigen::Quaterniond turn(w, x, y, z);
  const double off = std::abs(turn.norm() - 1);
  if (!(off <= kOff)) return std::nullopt;
  // A quaternion normalized once must read back to the same bits.
  return off <= kExact ? turn : turn.normalized();
}

std::string ToCsv(const PoseTable& table) {
  std::string text = "x,y,z";
  if (table.has_orientation) text += ",qw,qx,qy,qz";
  if (table.has_linear_velocity) text += ",vx,vy,vz";
  if (table.has_angular_velocity) text += ",wx,wy,wz";
  text += '\n';
  for (const PoseRow& row : table.rows) {
    const Eigen::Quaterniond& q = row.orientation;
    const Eigen::Vector3d &v = row.linear_velocity, &w = row.angular_velocity;
    AddNumbers(text, {row.position.x(), row.position.y(), row.position.z()});
    if (table.has_orientation) AddNumbers(text, {q.w(), q.x(), q.y(), q.z()});
    if (table.has_linear_velocity) AddNumbers(text, {v.x(), v.y(), v.z()});
    if (table.has_angular_velocity) AddNumbers(text, {w.x(), w.y(), w.z()});
    text += '\n';
  }
  return text;
}

}  // namespace cdb::layouts
