#include "library/layouts/pose_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "compiler/plan/text_table.h"
#include "compiler/schema/number.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"
#include "dsl/text/utf8.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using library::SceneError;

struct ColumnRow {
  std::string_view name, unit;
  std::string_view also = {};  ///< another heading for it
};
constexpr std::array<ColumnRow, kPoseColumns> kColumnRows = {{{"x", "m"},
                                                              {"y", "m"},
                                                              {"z", "m"},
                                                              {"qw", ""},
                                                              {"qx", ""},
                                                              {"qy", ""},
                                                              {"qz", ""},
                                                              {"vx", "m/s"},
                                                              {"vy", "m/s"},
                                                              {"vz", "m/s"},
                                                              {"wx", "rad/s"},
                                                              {"wy", "rad/s"},
                                                              {"wz", "rad/s"},
                                                              {"rx", "rad", "roll"},
                                                              {"ry", "rad", "pitch"},
                                                              {"rz", "rad", "yaw"},
                                                              {"t", "s"}}};

/// The columns of a quantity, which must be present together.
struct Quantity {
  std::size_t first, count;
  std::string_view names;
};
constexpr Quantity kPosition = {0, 3, "x, y, z"}, kOrientation = {3, 4, "qw, qx, qy, qz"},
                   kVelocity = {7, 3, "vx, vy, vz"}, kSpin = {10, 3, "wx, wy, wz"},
                   kAngles = {13, 3, "rx, ry, rz"}, kTime = {kTimeColumn, 1, "t"};
constexpr Quantity kOfPoses[] = {kPosition, kOrientation, kAngles, kVelocity, kSpin};
constexpr Quantity kOfPath[] = {kTime, kPosition, kOrientation, kAngles};

/// A kind of table.
struct Layout {
  std::span<const Quantity> quantities;
  std::string_view header;      ///< with only the required columns
  std::string_view columns;     ///< all, in words
  std::string_view by_number;   ///< an example for a file without headings
  std::string_view rows, none;  ///< noun for a line, and message if there are none
};
constexpr Layout kPoses = {
    kOfPoses,
    "x,y,z",
    "the columns are x, y, z and optionally qw, qx, qy, qz (or rx, ry, rz), vx, vy, vz, wx, wy, wz",
    "columns: \"x=#1, y=#2, z=#3\"",
    "object",
    "it has no objects"};
constexpr Layout kPath = {
    kOfPath,
    "t,x,y,z",
    "the columns of a path are t, x, y, z and optionally qw, qx, qy, qz (or rx, ry, rz)",
    "columns: \"t=#1, x=#2, y=#3, z=#4\"",
    "time",
    "it has no poses"};
constexpr double kLargest = 1e15;  ///< larger numbers are not valid

const Layout& LayoutOf(const schema::Call& call) {
  return call.name == schema::kPathCall ? kPath : kPoses;
}

const std::string& FileNamedBy(const schema::Call& call) {
  return std::get<schema::Text>(schema::ArgumentOf(call, "file")).text;
}

const std::string& WordOf(const schema::Call& call, std::string_view argument) {
  return std::get<schema::Word>(schema::ArgumentOf(call, argument)).text;
}

bool Takes(const Layout& layout, std::size_t column) {
  return std::ranges::any_of(layout.quantities, [column](const Quantity& quantity) {
    return column >= quantity.first && column < quantity.first + quantity.count;
  });
}

/// The column with this heading; nullopt if the layout has none.
std::optional<std::size_t> ColumnCalled(std::string_view heading, const Layout& layout) {
  for (std::size_t i = 0; i < kPoseColumns; ++i)
    if ((heading == kColumnRows[i].name || (!heading.empty() && heading == kColumnRows[i].also)) &&
        Takes(layout, i))
      return i;
  return std::nullopt;
}

}  // namespace

std::vector<NamedColumn> NamedColumns(const schema::Call& call) {
  const schema::Text* text = AsText(schema::ArgumentOf(call, "columns"));
  if (text == nullptr) return {};
  const Layout& layout = LayoutOf(call);
  std::vector<NamedColumn> columns;
  const auto add = [&](std::string_view part) {
    const std::size_t equals = part.find('=');
    const auto trimmed = [](std::string_view name) {
      while (name.starts_with(' ')) name.remove_prefix(1);
      while (name.ends_with(' ')) name.remove_suffix(1);
      return name;
    };
    const std::string_view name = trimmed(part.substr(0, equals));
    const auto column = ColumnCalled(name, layout);
    if (equals == part.npos || !column || trimmed(part.substr(equals + 1)).empty())
      throw SceneError(fmt::format("{}: `{}` in `columns` does not name a column",
                                   FileNamedBy(call), text::Printable(part)),
                       fmt::format("write them as in {}; {}", layout.by_number, layout.columns));
    if (std::ranges::find(columns, *column, &NamedColumn::column) != columns.end())
      throw SceneError(fmt::format("{}: `columns` names {} twice", FileNamedBy(call), name),
                       "keep one of them");
    columns.push_back({*column, std::string(trimmed(part.substr(equals + 1)))});
  };
  // A comma within brackets belongs to the name: `x=/pos[:,0]`.
  std::size_t begin = 0;
  int depth = 0;
  for (std::size_t i = 0; i <= text->text.size(); ++i) {
    const char c = i < text->text.size() ? text->text[i] : ',';
    if (c == '[') ++depth;
    if (c == ']') --depth;
    if (i < text->text.size() && (c != ',' || depth > 0)) continue;
    add(std::string_view(text->text).substr(begin, i - begin));
    begin = i + 1;
  }
  return columns;
}

void CheckUnit(std::size_t column, const std::optional<text::Unit>& unit, const std::string& name,
               const std::string& place) {
  const ColumnRow& row = kColumnRows[column];
  const bool is_angle = row.unit == "rad";
  if (!unit && is_angle)
    throw SceneError(
        fmt::format("{}: the angles in the column `{}` have no unit", place, text::Printable(name)),
        fmt::format("write deg or rad into the heading, or columns: \"{}={} [deg], …\"", row.name,
                    name));
  if (!unit || unit->HasDimensionOf(*text::ParseUnit(row.unit))) return;
  throw SceneError(fmt::format("{}: the column `{}` cannot be {} in this unit", place,
                               text::Printable(name), row.name),
                   row.unit.empty()
                       ? std::string("a quaternion has no unit")
                       : fmt::format("{} is in {} or a multiple of it", row.name, row.unit));
}

namespace {

/// The table while its poses are made.
class PoseMaker {
 public:
  PoseMaker(const PoseColumns& columns, const schema::Call& call)
      : columns_(columns),
        layout_(LayoutOf(call)),
        rotation_(WordOf(call, "rotation")),
        is_z_up_(WordOf(call, "up") == "z"),
        starts_first_(call.name == schema::kPathCall && WordOf(call, "start") == "first") {}

  PoseTable Make() const {
    CheckQuantities();
    PoseTable table;
    table.has_time = Has(kTime);
    table.has_orientation = Has(kOrientation) || Has(kAngles);
    table.has_linear_velocity = Has(kVelocity);
    table.has_angular_velocity = Has(kSpin);
    for (std::size_t i = 0; i < columns_.rows; ++i) {
      table.rows.push_back(RowAt(i));
      if (Has(kTime)) table.rows.back().time = TimeAt(i);
    }
    if (table.rows.empty())
      Refuse(columns_.name, std::string(layout_.none),
             fmt::format("write a line for each {}", layout_.rows));
    return table;
  }

 private:
  [[noreturn]] static void Refuse(const std::string& place, const std::string& cause,
                                  const std::string& remedy) {
    throw SceneError(fmt::format("{}: {}", place, cause), remedy);
  }

  bool HasColumn(std::size_t column) const { return columns_.has[column]; }
  bool Has(const Quantity& quantity) const { return HasColumn(quantity.first); }

  void CheckQuantities() const {
    for (const Quantity& quantity : layout_.quantities) {
      std::size_t there = 0;
      for (std::size_t i = 0; i < quantity.count; ++i) there += HasColumn(quantity.first + i);
      if (quantity.first == kTime.first && there == 0)
        Refuse(columns_.name, "the column t is missing", "a path has times and positions: t,x,y,z");
      if (there != quantity.count && (there > 0 || quantity.first == 0))
        Refuse(
            columns_.name,
            fmt::format("{} of the columns {} are missing", quantity.count - there, quantity.names),
            quantity.first == 0 ? "a position needs all three" : "give all of them, or none");
    }
    if (Has(kAngles) && Has(kOrientation))
      Refuse(columns_.name, "it has both qw, qx, qy, qz and rx, ry, rz",
             "name the columns of one of them by `columns`");
    if (Has(kAngles) && rotation_ == "none")
      Refuse(
          columns_.name, "the meaning of rx, ry, rz (roll, pitch, yaw) is not stated",
          "write rotation: extrinsic_xyz (about fixed axes: first x, then y, then z; the same as "
          "intrinsic_zyx), or another order");
    if (!Has(kAngles) && rotation_ != "none")
      Refuse(columns_.name, "`rotation` is given, but there are no columns rx, ry, rz",
             "remove rotation");
  }

  Vector3d VectorAt(std::size_t row, const Quantity& quantity) const {
    Vector3d v = Vector3d::Zero();
    if (!Has(quantity)) return v;
    for (std::size_t i = 0; i < 3; ++i)
      v[static_cast<int>(i)] = columns_.values[quantity.first + i][row];
    return v;
  }

  /// The vector in the frame of cdb, in which y is up.
  Vector3d Turned(const Vector3d& v) const { return is_z_up_ ? Vector3d(v.x(), v.z(), -v.y()) : v; }

  PoseRow RowAt(std::size_t i) const {
    for (std::size_t column = 0; column < kPoseColumns; ++column)
      if (HasColumn(column) && std::abs(columns_.values[column][i]) > kLargest)
        Refuse(columns_.place(i),
               fmt::format("{} is {:g}, beyond {:g}", kColumnRows[column].name,
                           columns_.values[column][i], kLargest),
               column == kTime.first
                   ? "times are in s; write their unit after the name of the column, as in "
                     "columns: \"t=time [ns], …\""
                   : "positions and velocities are in m, m/s and rad/s");
    PoseRow row;
    row.position = Turned(VectorAt(i, kPosition));
    row.linear_velocity = Turned(VectorAt(i, kVelocity));
    row.angular_velocity = Turned(VectorAt(i, kSpin));
    if (Has(kOrientation)) row.orientation = QuaternionAt(i);
    if (Has(kAngles)) row.orientation = FromAngles(VectorAt(i, kAngles));
    // A quarter turn about x, from z to y.
    if (is_z_up_ && (Has(kOrientation) || Has(kAngles)))
      row.orientation =
          (Quaterniond(std::sqrt(0.5), -std::sqrt(0.5), 0, 0) * row.orientation).normalized();
    return row;
  }

  double TimeAt(std::size_t i) const {
    const std::vector<double>& times = columns_.values[kTime.first];
    if (i > 0 && !(times[i] > times[i - 1]))
      Refuse(columns_.place(i),
             fmt::format("t is {}, but {} in the line before", schema::FormatReal(times[i]),
                         schema::FormatReal(times[i - 1])),
             "write the lines in the order of their times");
    return starts_first_ ? times[i] - times[0] : times[i];
  }

  Quaterniond QuaternionAt(std::size_t i) const {
    const auto at = [&](std::size_t k) { return columns_.values[kOrientation.first + k][i]; };
    const auto turn = UnitQuaternion(at(0), at(1), at(2), at(3));
    if (!turn)
      Refuse(columns_.place(i), "qw, qx, qy, qz are not a unit quaternion",
             "their squares must add up to 1; 1, 0, 0, 0 is no rotation");
    return *turn;
  }

  Quaterniond FromAngles(const Vector3d& angles) const {
    if (rotation_ == "vector") {
      const double angle = angles.norm();
      if (angle == 0) return Quaterniond::Identity();
      return Quaterniond(Eigen::AngleAxisd(angle, angles / angle)).normalized();
    }
    Quaterniond turn = Quaterniond::Identity();
    const bool is_intrinsic = rotation_.starts_with("intrinsic");
    for (const char axis : std::string_view(rotation_).substr(rotation_.size() - 3)) {
      const int i = axis - 'x';
      const Quaterniond next(Eigen::AngleAxisd(angles[i], Vector3d::Unit(i)));
      turn = is_intrinsic ? turn * next : next * turn;
    }
    return turn.normalized();
  }

  const PoseColumns& columns_;
  const Layout& layout_;
  const std::string& rotation_;
  const bool is_z_up_, starts_first_;
};

}  // namespace

PoseTable PosesOfColumns(const PoseColumns& columns, const schema::Call& call) {
  return PoseMaker(columns, call).Make();
}

// Text files.

namespace {

using plan::Column;
using plan::TextTable;

/// The parts of a heading, in lower case: `field.pose.position.x` is field, pose, position, x.
std::vector<std::string> WordsIn(const std::string& heading) {
  std::vector<std::string> words(1);
  for (const char c : plan::ParseColumnName(heading).stem) {
    if (text::IsNameChar(c) && c != '_') {
      words.back() += static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.size() > 1 && words.back().empty()) words.pop_back();
  return words;
}

/// True if the heading looks like that of the column, for a suggestion.
bool LooksLike(const std::string& heading, std::size_t column) {
  const std::vector<std::string> words = WordsIn(heading);
  const auto begins = [&](std::initializer_list<std::string_view> with) {
    return std::ranges::any_of(words, [&](const std::string& word) {
      return word != words.back() && std::ranges::any_of(with, [&](std::string_view begin) {
               return begin.size() == 1 ? word == begin : word.starts_with(begin);
             });
    });
  };
  const std::string_view name = kColumnRows[column].name, last = words.back();
  const std::string_view axis = name.substr(name.size() - 1);
  if (column == kTime.first)
    return last == "t" || last.starts_with("time") || last.ends_with("stamp") || last == "sec";
  if (column < kPosition.count)
    return last == fmt::format("t{}", axis) || last == fmt::format("p{}", axis) ||
           last == fmt::format("pos{}", axis) ||
           (last == axis && !begins({"orient", "quat", "rot", "q", "vel", "v", "ang", "lin",
                                     "twist", "acc", "a", "b", "w"}));
  return last == name || last == fmt::format("ori{}", axis) ||
         last == fmt::format("quat{}", axis) ||
         (last == axis && begins({"orient", "quat", "rot", "q"}));
}

/// `columns: "x=pos.x, y=pos.y, z=…"`: the columns of the table, as far as they can be told.
std::string SuggestedColumns(const TextTable& table, const Layout& layout) {
  const std::vector<std::string>& headings = table.headings();
  const auto has_value = [&](std::size_t i) {
    return table.rows() == 0 || !table.Cell(0, i).empty();
  };
  std::string text;
  for (const Quantity& quantity : layout.quantities) {
    if (quantity.first > kOrientation.first && quantity.first != kTime.first) continue;
    std::string part;
    bool is_complete = true;
    for (std::size_t column = quantity.first; column < quantity.first + quantity.count; ++column) {
      std::size_t i = 0;
      while (i < headings.size() && !(LooksLike(headings[i], column) && has_value(i))) ++i;
      std::string name = "…";
      // Of several headings alike, only the user knows which.
      if (i == headings.size() || std::ranges::count(headings, headings[i]) > 1) {
        is_complete = false;
      } else {
        name = headings[i].find_first_of(",=\"\\") != std::string::npos ? fmt::format("#{}", i + 1)
                                                                        : headings[i];
      }
      part += fmt::format("{}{}={}", part.empty() ? "" : ", ", kColumnRows[column].name, name);
    }
    if (is_complete || quantity.first != kOrientation.first)
      text += (text.empty() ? "" : ", ") + part;
  }
  return fmt::format("columns: \"{}\"", text::Printable(text));
}

/// The columns with the names of cdb's own; refuses others.
std::vector<std::pair<std::size_t, Column>> OwnColumns(TextTable& table, const Layout& layout) {
  const std::vector<std::string>& headings = table.headings();
  if (headings.empty())
    throw SceneError(fmt::format("{}: it has no headings", table.PlaceOfHeadings()),
                     fmt::format("write a line of column names first: {}, or name the columns by "
                                 "their numbers: {}",
                                 layout.header, layout.by_number));
  std::vector<std::pair<std::size_t, Column>> columns;
  std::string unknown;
  std::size_t unknown_count = 0;
  for (std::size_t i = 0; i < headings.size(); ++i) {
    const auto column = ColumnCalled(plan::ParseColumnName(headings[i]).stem, layout);
    if (!column) {
      if (table.IsEmptyColumn(i)) continue;
      if (++unknown_count <= 4)
        unknown += fmt::format(
            "{}`{}`", unknown.empty() ? "" : ", ",
            headings[i].empty() ? fmt::format("#{}", i + 1) : text::Printable(headings[i]));
      continue;
    }
    if (std::ranges::find(columns, *column, &std::pair<std::size_t, Column>::first) !=
        columns.end())
      throw SceneError(fmt::format("{}: the column `{}` occurs twice", table.PlaceOfHeadings(),
                                   kColumnRows[*column].name),
                       fmt::format("name those to read: {}; it has {}",
                                   SuggestedColumns(table, layout), table.ColumnList()));
    columns.emplace_back(*column, table.At(i));
  }
  if (unknown_count > 0)
    throw SceneError(
        fmt::format("{}: {}{} {}", table.PlaceOfHeadings(), unknown, unknown_count > 4 ? ", …" : "",
                    unknown_count == 1 ? "is not a known column" : "are not known columns"),
        table.HeaderAdvice().empty()
            ? fmt::format("name those to read: {}; it has {}; {}", SuggestedColumns(table, layout),
                          table.ColumnList(), layout.columns)
            : table.HeaderAdvice());
  return columns;
}

PoseTable PosesOfText(std::string_view text, const schema::Call& call) {
  const Layout& layout = LayoutOf(call);
  TextTable table(text, FileNamedBy(call), plan::DialectOf(call));
  if (table.width() == 0)
    throw SceneError(fmt::format("{}: it is empty", FileNamedBy(call)),
                     fmt::format("write a line of column names first: {}", layout.header));
  std::vector<std::pair<std::size_t, Column>> columns;
  for (const NamedColumn& named : NamedColumns(call))
    columns.emplace_back(named.column, table.Find(named.written));
  if (columns.empty()) columns = OwnColumns(table, layout);
  PoseColumns numbers;
  numbers.rows = table.rows();
  numbers.name = table.PlaceOfHeadings();
  numbers.place = [&table](std::size_t row) { return table.Place(row); };
  std::vector<Column> read;
  for (auto& [column, from] : columns) {
    CheckUnit(column, from.unit, from.name, numbers.name);
    read.push_back(from);
    numbers.has[column] = true;
    numbers.values[column].reserve(table.rows());
    from.name = kColumnRows[column].name;
  }
  table.FindDecimal(read);
  for (std::size_t row = 0; row < table.rows(); ++row)
    for (const auto& [column, from] : columns)
      numbers.values[column].push_back(table.Number(row, from));
  return PosesOfColumns(numbers, call);
}

}  // namespace

PoseTable ParsePoseText(std::string_view text, const schema::Call& call) {
  try {
    return PosesOfText(text, call);
  } catch (const plan::TableError& error) {
    throw SceneError(error.what(), error.remedy);
  }
}

}  // namespace cdb::layouts
