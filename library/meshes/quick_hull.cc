#include "library/meshes/quick_hull.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace cdb::meshes {
namespace {

using Eigen::Vector3d;

constexpr double kTolerance = 1e-7;

}  // namespace

double QuickHull::Distance(const Face& face, std::uint32_t point) const {
  return face.normal.dot(points_[point]) - face.offset;
}

std::uint32_t QuickHull::AddFace(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const Vector3d &pa = points_[a], &pb = points_[b], &pc = points_[c];
  Vector3d normal = (pb - pa).cross(pc - pa);
  const double length = std::sqrt(normal.squaredNorm());
  // A face without area sees nothing.
  normal = length > tolerance_ * tolerance_ * 1e-4 ? Vector3d(normal / length) : Vector3d::Zero();
  const double offset = normal.dot(pa);
  faces_.push_back(
      {{a, b, c}, {kNone, kNone, kNone}, normal, offset, kNone, kNone, 0, kNone, true});
  return static_cast<std::uint32_t>(faces_.size() - 1);
}

bool QuickHull::Start() {
  faces_.clear();
  if (points_.size() < 4) return false;
  std::array<std::uint32_t, 2> ends{0, 0};
  double extent = 0;
  for (int axis = 0; axis < 3; ++axis) {
    std::uint32_t low = 0, high = 0;
    for (std::uint32_t i = 1; i < points_.size(); ++i) {
      if (points_[i][axis] < points_[low][axis]) low = i;
      if (points_[i][axis] > points_[high][axis]) high = i;
    }
    const double along = points_[high][axis] - points_[low][axis];
    if (along > extent) {
      extent = along;
      ends = {low, high};
    }
  }
  tolerance_ = kTolerance * extent;
  if (!(extent > 0)) return false;
  const Vector3d &p = points_[ends[0]], along = points_[ends[1]] - p;
  const auto farthest = [&](const auto& measure) {
    std::uint32_t at = 0;
    double most = -1;
    for (std::uint32_t i = 0; i < points_.size(); ++i)
      if (const double d = measure(points_[i]); d > most) {
        most = d;
        at = i;
      }
    return at;
  };
  const std::uint32_t third =
      farthest([&](const Vector3d& q) { return (q - p).cross(along).squaredNorm(); });
  const Vector3d normal = along.cross(points_[third] - p);
  const double area = std::sqrt(normal.squaredNorm());
  if (!(area > tolerance_ * extent)) return false;
  const std::uint32_t fourth =
      farthest([&](const Vector3d& q) { return std::abs(normal.dot(q - p)); });
  const double height = normal.dot(points_[fourth] - p) / area;
  if (!(std::abs(height) > tolerance_)) return false;
  // Counter-clockwise from outside: the fourth corner is below the first face.
  std::array<std::uint32_t, 4> t{ends[0], ends[1], third, fourth};
  if (height > 0) std::swap(t[0], t[1]);
  AddFace(t[0], t[1], t[2]);
  AddFace(t[0], t[3], t[1]);
  AddFace(t[1], t[3], t[2]);
  AddFace(t[2], t[3], t[0]);
  faces_[0].next = {1, 2, 3};
  faces_[1].next = {3, 2, 0};
  faces_[2].next = {1, 3, 0};
  faces_[3].next = {2, 1, 0};
  return true;
}

void QuickHull::Assign(std::uint32_t point, std::size_t first_face) {
  for (std::size_t i = first_face; i < faces_.size(); ++i) {
    Face& face = faces_[i];
    const double distance = Distance(face, point);
    if (distance <= tolerance_) continue;
    next_point_[point] = face.outside;
    face.outside = point;
    if (distance > face.distance) {
      face.distance = distance;
      face.farthest = point;
    }
    return;
  }
}

void QuickHull::FindVisible(std::uint32_t face, std::uint32_t eye) {
  visible_.assign(1, face);
  horizon_.clear();
  faces_[face].seen_from = eye;
  for (std::size_t i = 0; i < visible_.size(); ++i) {
    const Face& seen = faces_[visible_[i]];
    for (std::size_t k = 0; k < 3; ++k) {
      Face& beyond = faces_[seen.next[k]];
      if (beyond.seen_from == eye) continue;
      if (Distance(beyond, eye) > tolerance_) {
        beyond.seen_from = eye;
        visible_.push_back(seen.next[k]);
      } else {
        horizon_.push_back({seen.corner[k], seen.corner[(k + 1) % 3], seen.next[k]});
      }
    }
  }
}

double QuickHull::AddedVolume(std::uint32_t face, std::uint32_t eye) {
  FindVisible(face, eye);
  double volume = 0;
  for (const std::uint32_t seen : visible_) {
    const auto& [a, b, c] = faces_[seen].corner;
    volume +=
        (points_[b] - points_[a]).cross(points_[c] - points_[a]).dot(points_[eye] - points_[a]);
    faces_[seen].seen_from = kNone;
  }
  return volume;
}

/// Removes the farthest point of a face from its list.
void QuickHull::Drop(std::uint32_t index) {
  Face& face = faces_[index];
  const std::uint32_t dropped = face.farthest;
  std::uint32_t point = face.outside;
  face.outside = face.farthest = kNone;
  face.distance = 0;
  while (point != kNone) {
    const std::uint32_t next = next_point_[point];
    if (point != dropped) {
      const double distance = Distance(face, point);
      next_point_[point] = face.outside;
      face.outside = point;
      if (distance > face.distance) {
        face.distance = distance;
        face.farthest = point;
      }
    }
    point = next;
  }
}

void QuickHull::Add(std::uint32_t index) {
  const std::uint32_t eye = faces_[index].farthest;
  FindVisible(index, eye);
  // Rounding may leave a horizon that is no loop; such a point is next to the hull.
  bool is_loop = true;
  for (const HorizonEdge& edge : horizon_) {
    is_loop = is_loop && starts_[edge.from] == kNone;
    starts_[edge.from] = edge.to;
  }
  for (const HorizonEdge& edge : horizon_) is_loop = is_loop && starts_[edge.to] != kNone;
  for (const HorizonEdge& edge : horizon_) starts_[edge.from] = kNone;
  if (!is_loop) {
    for (const std::uint32_t seen : visible_) faces_[seen].seen_from = kNone;
    Drop(index);
    return;
  }
  const std::size_t first = faces_.size();
  for (const HorizonEdge& edge : horizon_) {
    const std::uint32_t face = AddFace(edge.from, edge.to, eye);
    starts_[edge.from] = face;
    faces_[face].next[0] = edge.beyond;
    Face& beyond = faces_[edge.beyond];
    for (std::size_t k = 0; k < 3; ++k)
      if (beyond.corner[k] == edge.to && beyond.corner[(k + 1) % 3] == edge.from)
        beyond.next[k] = face;
  }
  for (std::size_t i = first; i < faces_.size(); ++i) {
    const std::uint32_t after = starts_[faces_[i].corner[1]];
    faces_[i].next[1] = after;
    faces_[after].next[2] = static_cast<std::uint32_t>(i);
  }
  for (const HorizonEdge& edge : horizon_) starts_[edge.from] = kNone;
  for (const std::uint32_t seen : visible_) {
    faces_[seen].is_alive = false;
    for (std::uint32_t point = faces_[seen].outside; point != kNone;) {
      const std::uint32_t next = next_point_[point];
      if (point != eye) Assign(point, first);
      point = next;
    }
  }
}

std::uint32_t QuickHull::LargestGain() {
  std::uint32_t best = kNone;
  double most = 0;
  for (std::uint32_t i = 0; i < faces_.size(); ++i) {
    if (!faces_[i].is_alive || faces_[i].outside == kNone) continue;
    if (const double gain = AddedVolume(i, faces_[i].farthest); gain > most) {
      most = gain;
      best = i;
    }
  }
  return best;
}

bool QuickHull::Begin(std::span<const Vector3d> points) {
  points_ = points;
  if (!Start()) {
    faces_.clear();
    return false;
  }
  next_point_.assign(points_.size(), kNone);
  starts_.assign(points_.size(), kNone);
  for (std::uint32_t i = 0; i < points_.size(); ++i) Assign(i, 0);
  return true;
}

double QuickHull::Measure() const {
  const Vector3d apex = points_[faces_[0].corner[0]];
  double six = 0;
  for (const Face& face : faces_) {
    if (!face.is_alive) continue;
    const auto& [a, b, c] = face.corner;
    six += (points_[a] - apex).dot((points_[b] - apex).cross(points_[c] - apex));
  }
  return six / 6;
}

double QuickHull::Volume(std::span<const Vector3d> points) {
  if (!Begin(points)) return 0;
  for (std::uint32_t i = 0; i < faces_.size(); ++i)
    while (faces_[i].is_alive && faces_[i].outside != kNone) Add(i);
  return Measure();
}

double QuickHull::Volume(std::span<const Vector3d> points, std::size_t most, double enough) {
  if (!Begin(points)) return 0;
  for (std::size_t corners = 4; corners < most && Measure() < enough; ++corners) {
    const std::uint32_t face = LargestGain();
    if (face == kNone) break;
    Add(face);
  }
  return Measure();
}

std::vector<std::uint32_t> QuickHull::Corners() const {
  std::vector<std::uint32_t> corners;
  for (const Face& face : faces_)
    if (face.is_alive) corners.insert(corners.end(), face.corner.begin(), face.corner.end());
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return corners;
}

}  // namespace cdb::meshes
