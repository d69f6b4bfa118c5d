#include "library/layouts/path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compiler/schema/parametrised_words.h"
#include "library/scene_error.h"

namespace cdb::layouts {
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
  return {sha256, 1, path.has_orientation(), true, path.has_orientation()};
}

}  // namespace cdb::layouts
