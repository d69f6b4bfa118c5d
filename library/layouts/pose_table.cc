#include "library/layouts/pose_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "compiler/plan/input_file.h"
#include "compiler/schema/number.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"
#include "dsl/text/utf8.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

using library::SceneError;

constexpr std::string_view kPlanAgain = "plan again from the .cdb file, or put the other file back";

ReadHdf5Poses& Hdf5Reader() {
  static ReadHdf5Poses reader;
  return reader;
}

const std::string& FileOf(const schema::Call& poses) {
  return std::get<schema::Text>(schema::ArgumentOf(poses, "file")).text;
}

struct Unreadable : SceneError {
  using SceneError::SceneError;
};

[[noreturn]] void FailToRead(const std::string& path, const std::string& why) {
  throw Unreadable(fmt::format("{}: {}", path, why),
                   "the path is relative to the folder of the .cdb file");
}

/// The table, and the hash of its source: the CSV file, or the values read from HDF5.
std::pair<PoseTable, std::string> ReadWithHash(const schema::Call& poses) {
  if (analysis::IsCsv(poses)) {
    std::string why;
    const auto bytes = plan::ReadInputFile(FileOf(poses), why);
    if (!bytes) FailToRead(FileOf(poses), why);
    const auto parse = poses.name == schema::kPathCall ? ParsePathCsv : ParsePoseCsv;
    return {parse(*bytes, FileOf(poses)), plan::Sha256Hex(*bytes)};
  }
  if (!Hdf5Reader())
    throw SceneError(fmt::format("{}: nothing here reads HDF5", FileOf(poses)),
                     "run it by `cdb run`");
  PoseTable table = Hdf5Reader()(poses);
  std::string sha256 = plan::Sha256Hex(ToCsv(table));
  return {std::move(table), std::move(sha256)};
}

}  // namespace

void SetPoseReader(ReadHdf5Poses reader) { Hdf5Reader() = std::move(reader); }

PoseTable ReadPoseTable(const schema::Call& poses) {
  auto [table, sha256] = ReadWithHash(poses);
  const auto* planned = std::get_if<schema::Text>(&schema::ArgumentOf(poses, "sha256"));
  if (planned != nullptr && planned->text != sha256)
    throw SceneError(
        fmt::format("{}: it differs from the file that the plan was made with", FileOf(poses)),
        std::string(kPlanAgain));
  return std::move(table);
}

std::optional<analysis::PoseFacts> ReadPoseFacts(const schema::Call& poses,
                                                 analysis::PoseFault& why) {
  try {
    if (const std::string fault = plan::WhyNotReadable(FileOf(poses)); !fault.empty())
      FailToRead(FileOf(poses), fault);
    const auto [table, sha256] = ReadWithHash(poses);
    if (poses.name == schema::kPathCall) return FactsOfPath(Path(poses, table), sha256);
    analysis::PoseFacts facts;
    facts.sha256 = sha256;
    facts.count = table.rows.size();
    facts.has_orientation = table.has_orientation;
    facts.has_linear_velocity = table.has_linear_velocity;
    facts.has_angular_velocity = table.has_angular_velocity;
    return facts;
  } catch (const SceneError& error) {
    why = {dynamic_cast<const Unreadable*>(&error) != nullptr, error.cause(), error.remedy()};
    return std::nullopt;
  }
}

std::string PackPoses(const plan::Scene& scene) {
  std::string packed;
  for (const plan::Group& group : scene.groups) {
    const schema::Call* poses = analysis::PosesOf(group);
    if (poses == nullptr || analysis::IsCsv(*poses)) continue;
    const PoseTable table = ReadPoseTable(*poses);
    const std::string key = schema::ToText(schema::Value(*poses)), csv = ToCsv(table);
    // The line before each table has the lengths of key and table.
    packed += fmt::format("{} {}\n", key.size(), csv.size()) + key + csv;
  }
  return packed;
}

PoseTable UnpackPoses(std::string_view packed, const schema::Call& poses) {
  const std::string wanted = schema::ToText(schema::Value(poses));
  while (!packed.empty()) {
    std::size_t sizes[2] = {0, 0};
    const char *at = packed.data(), *end = packed.data() + packed.size();
    for (std::size_t& size : sizes) {
      at = std::from_chars(at, end, size).ptr;
      CDB_CHECK(at < end);
      ++at;
    }
    packed.remove_prefix(static_cast<std::size_t>(at - packed.data()));
    CDB_CHECK(sizes[0] + sizes[1] <= packed.size());
    if (packed.substr(0, sizes[0]) == wanted)
      return ParsePoseCsv(packed.substr(sizes[0], sizes[1]), FileOf(poses));
    packed.remove_prefix(sizes[0] + sizes[1]);
  }
  throw SceneError(fmt::format("{}: its poses did not come with the run", FileOf(poses)),
                   "run it by `cdb run`");
}

namespace {

bool Repeats(const schema::Call& call) {
  return std::get<schema::Word>(schema::ArgumentOf(call, "then")).text == "repeat";
}

/// The same position and rotation; a quaternion and its negative are the same rotation.
bool AreSamePose(const PoseRow& a, const PoseRow& b) {
  constexpr double kTurnRounding = 1e-9;
  return a.position == b.position && 1 - std::abs(a.orientation.dot(b.orientation)) < kTurnRounding;
}

}  // namespace

Path::Path(const schema::Call& call, const PoseTable& table)
    : rows_(table.rows), has_orientation_(table.has_orientation), repeats_(Repeats(call)) {
  const std::string& file = std::get<schema::Text>(schema::ArgumentOf(call, "file")).text;
  if (repeats_ && rows_.size() < 2)
    throw library::SceneError(fmt::format("{}: a path of one pose cannot repeat", file),
                              "write more lines, or remove `then`");
  if (repeats_ && !AreSamePose(rows_.front(), rows_.back()))
    throw library::SceneError(
        fmt::format("{}: it repeats, but its last pose differs from its first", file),
        "end the path where it begins, or remove `then`");
}

Path::Between Path::At(double time) const {
  const double first = rows_.front().time, last = rows_.back().time;
  if (repeats_) time -= std::floor((time - first) / (last - first)) * (last - first);
  if (!(time > first)) return {&rows_.front(), &rows_.front(), 0};
  if (!(time < last)) return {&rows_.back(), &rows_.back(), 0};
  const auto to = std::ranges::upper_bound(rows_, time, {}, &PoseRow::time), from = to - 1;
  return {&*from, &*to, (time - from->time) / (to->time - from->time)};
}

Eigen::Vector3d Path::PositionAt(double time) const {
  const auto [from, to, part] = At(time);
  return from->position + part * (to->position - from->position);
}

Eigen::Quaterniond Path::OrientationAt(double time) const {
  const auto [from, to, part] = At(time);
  if (part == 0) return from->orientation;
  return from->orientation.slerp(part, to->orientation).normalized();
}

Path ReadPath(const schema::Call& call) { return {call, ReadPoseTable(call)}; }

analysis::PoseFacts FactsOfPath(const Path& path, const std::string& sha256) {
  analysis::PoseFacts facts;
  facts.sha256 = sha256;
  facts.count = 1;
  facts.has_orientation = facts.has_angular_velocity = path.has_orientation();
  facts.has_linear_velocity = true;
  const std::vector<PoseRow>& rows = path.rows();
  facts.least = facts.most = rows.front().position;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Vector3d &from = rows[i - 1].position, &to = rows[i].position;
    facts.least = facts.least.cwiseMin(to);
    facts.most = facts.most.cwiseMax(to);
    facts.fastest = std::max(facts.fastest, (to - from).norm() / (rows[i].time - rows[i - 1].time));
  }
  return facts;
}

// The CSV files of poses and paths.

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
