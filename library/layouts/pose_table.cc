#include "library/layouts/pose_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "compiler/plan/input_file.h"
#include "compiler/schema/number.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"
#include "library/layouts/pose_columns.h"
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
    return {ParsePoseText(*bytes, poses), plan::Sha256Hex(*bytes)};
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
    if (poses == nullptr) poses = analysis::PathOf(group);
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
      return ParsePoseText(packed.substr(sizes[0], sizes[1]), TableCall(poses.name, FileOf(poses)));
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
  facts.first_time = rows.front().time;
  facts.last_time = rows.back().time;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Eigen::Vector3d &from = rows[i - 1].position, &to = rows[i].position;
    facts.least = facts.least.cwiseMin(to);
    facts.most = facts.most.cwiseMax(to);
    facts.fastest = std::max(facts.fastest, (to - from).norm() / (rows[i].time - rows[i - 1].time));
  }
  return facts;
}

// The CSV files of poses and paths, for another process.

namespace {

void AddNumbers(std::string& text, std::initializer_list<double> values) {
  for (const double value : values) {
    if (!text.empty() && text.back() != '\n') text += ',';
    text += schema::FormatReal(value);
  }
}

}  // namespace

schema::Call TableCall(std::string_view name, std::string_view file) {
  schema::Call call{std::string(name), {}};
  for (const schema::Parameter& argument : schema::FindParametrisedWord(name)->arguments)
    call.arguments.push_back(argument.name == "file"
                                 ? schema::Value(schema::Text{std::string(file)})
                                 : schema::DefaultOf(argument));
  return call;
}

PoseTable ParsePoseCsv(std::string_view csv, std::string_view name) {
  return ParsePoseText(csv, TableCall(schema::kPosesCall, name));
}

PoseTable ParsePathCsv(std::string_view csv, std::string_view name) {
  return ParsePoseText(csv, TableCall(schema::kPathCall, name));
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
  std::string text = table.has_time ? "t,x,y,z" : "x,y,z";
  if (table.has_orientation) text += ",qw,qx,qy,qz";
  if (table.has_linear_velocity) text += ",vx,vy,vz";
  if (table.has_angular_velocity) text += ",wx,wy,wz";
  text += '\n';
  for (const PoseRow& row : table.rows) {
    const Eigen::Quaterniond& q = row.orientation;
    const Eigen::Vector3d &v = row.linear_velocity, &w = row.angular_velocity;
    if (table.has_time) AddNumbers(text, {row.time});
    AddNumbers(text, {row.position.x(), row.position.y(), row.position.z()});
    if (table.has_orientation) AddNumbers(text, {q.w(), q.x(), q.y(), q.z()});
    if (table.has_linear_velocity) AddNumbers(text, {v.x(), v.y(), v.z()});
    if (table.has_angular_velocity) AddNumbers(text, {w.x(), w.y(), w.z()});
    text += '\n';
  }
  return text;
}

}  // namespace cdb::layouts
