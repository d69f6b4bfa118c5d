#include "library/meshes/cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>

namespace cdb::meshes {
namespace {

using Eigen::Vector3d;

/// Edges that all tried planes of one piece visit together, and planes.
constexpr std::size_t kMostWork = 10'000'000, kLeastPlanes = 24, kMostPlanes = 400;
/// What cutting along all concave edges is worth, as a fraction of the defect; and cutting through
/// the middle.
constexpr double kConcavityWeight = 0.03, kBalanceWeight = 0.001;
constexpr std::size_t kFacePlanes = 32, kPairedEdges = 8, kRefined = 3;

}  // namespace

void CutSearch::AddEdge(const Piece& piece, std::span<const std::array<std::uint32_t, 4>> sides) {
  const std::uint32_t from = sides[0][0], to = sides[0][1];
  if (sides.size() != 2) {
    edges_.push_back({from, to, true});
    return;
  }
  const std::int32_t first = piece.caps[sides[0][3]], second = piece.caps[sides[1][3]];
  if (first != kSurface || second != kSurface) {
    edges_.push_back({from, to, first != second});
    return;
  }
  const Vector3d &a = vertices_[from], &b = vertices_[to];
  std::array<Plane, 2> faces;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto corners = CornersOf(piece.mesh, piece.mesh.triangles[sides[k][3]]);
    Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const double length = std::sqrt(normal.squaredNorm());
    normal = length > 0 ? Vector3d(normal / length) : Vector3d::Zero();
    faces[k] = {normal, normal.dot(a)};
  }
  const double rise = faces[0].Above(vertices_[sides[1][2]]);
  edges_.push_back({from, to, rise < 1e-9 * flat_ || faces[0].normal.isZero()});
  if (!(rise > flat_)) return;
  const double sine = std::sqrt(faces[0].normal.cross(faces[1].normal).squaredNorm());
  const double weight = sine * std::sqrt((b - a).squaredNorm());
  if (sine > 0.05) concave_.push_back({from, to, weight, faces});
}

void CutSearch::Prepare(const Piece& piece) {
  vertices_ = piece.mesh.vertices;
  hull_volume_ = piece.hull_volume;
  defect_ = piece.Defect();
  edges_.clear();
  concave_.clear();
  candidates_.clear();
  // By edge: its ends, the opposite corner, the triangle.
  std::vector<std::array<std::uint32_t, 4>> sides;
  sides.reserve(3 * piece.mesh.triangles.size());
  for (std::uint32_t i = 0; i < piece.mesh.triangles.size(); ++i) {
    const Triangle& t = piece.mesh.triangles[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      sides.push_back({low, high, t[(k + 2) % 3], i});
    }
  }
  std::sort(sides.begin(), sides.end());
  for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
    for (end = begin; end < sides.size() && sides[end][0] == sides[begin][0] &&
                      sides[end][1] == sides[begin][1];)
      ++end;
    AddEdge(piece, std::span(sides).subspan(begin, end - begin));
  }
  // At a corner of a hull, at least three edges are convex.
  std::vector<std::uint8_t> convex(vertices_.size(), 0);
  for (const Edge& edge : edges_)
    if (edge.is_convex)
      for (const std::uint32_t end : {edge.from, edge.to})
        if (convex[end] < 3) ++convex[end];
  is_corner_.resize(vertices_.size());
  for (std::size_t i = 0; i < vertices_.size(); ++i) is_corner_[i] = convex[i] == 3;
  std::stable_sort(concave_.begin(), concave_.end(),
                   [](const ConcaveEdge& a, const ConcaveEdge& b) { return a.weight > b.weight; });
  concavity_ = 0;
  for (const ConcaveEdge& edge : concave_) concavity_ += edge.weight;
  evaluations_ = 0;
  budget_ = std::clamp(kMostWork / (edges_.size() + 1), kLeastPlanes, kMostPlanes);
}

/// The points that the hulls of one side need, by part. On the upper side, vertices of the plane
/// have other numbers than on the lower.
void CutSearch::Collect(int sign) {
  const auto count = static_cast<std::uint32_t>(vertices_.size());
  const auto number = [&](std::uint32_t vertex) {
    return side_[vertex] == 0 && sign > 0 ? vertex + count : vertex;
  };
  points_.clear();
  for (std::uint32_t i = 0; i < count; ++i)
    if (side_[i] == sign && is_corner_[i]) points_.emplace_back(parts_.Root(i), vertices_[i]);
  for (const Edge& edge : edges_) {
    const int from = side_[edge.from], to = side_[edge.to];
    if (from == to || (from != sign && to != sign)) continue;
    const std::uint32_t inner = from == sign ? edge.from : edge.to;
    const std::uint32_t outer = from == sign ? edge.to : edge.from;
    if (side_[outer] == 0) {
      points_.emplace_back(parts_.Root(number(inner)), vertices_[outer]);
    } else if (edge.is_convex) {
      const double at = above_[edge.from] / (above_[edge.from] - above_[edge.to]);
      points_.emplace_back(parts_.Root(inner),
                           vertices_[edge.from] + at * (vertices_[edge.to] - vertices_[edge.from]));
    }
  }
}

double CutSearch::HullsOf(int sign) {
  Collect(sign);
  if (points_.empty()) return -1;
  std::vector<std::uint32_t> slot(2 * vertices_.size(), kNoVertex);
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const auto& [root, point] : points_) {
    if (slot[root] == kNoVertex) {
      slot[root] = static_cast<std::uint32_t>(boxes.size());
      boxes.emplace_back();
    }
    boxes[slot[root]].extend(point);
  }
  // A part in the box of another may be its cavity, and counts with it.
  std::vector<std::uint32_t> owner(boxes.size(), 0);
  if (boxes.size() <= 4 * most_)
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      owner[i] = i;
      for (std::uint32_t k = 0; k < boxes.size(); ++k)
        if (k != i && boxes[k].contains(boxes[i]) && (k < i || !boxes[i].contains(boxes[k]))) {
          owner[i] = owner[k] < i ? owner[k] : k;
          break;
        }
    }
  std::uint32_t parts = 0;
  for (std::uint32_t i = 0; i < owner.size(); ++i) parts += owner[i] == i ? 1 : 0;
  if (parts > most_) std::fill(owner.begin(), owner.end(), 0);
  // Points by part, in their order.
  std::vector<std::size_t> ends(owner.size() + 1, 0);
  for (std::uint32_t& at : owner)
    while (owner[at] != at) at = owner[at];
  for (const auto& [root, point] : points_) ++ends[owner[slot[root]] + 1];
  for (std::size_t i = 1; i < ends.size(); ++i) ends[i] += ends[i - 1];
  part_points_.resize(points_.size());
  for (const auto& [root, point] : points_) part_points_[ends[owner[slot[root]]]++] = point;
  double volume = 0;
  for (std::size_t i = 0, begin = 0; i < owner.size(); begin = ends[i++])
    if (ends[i] > begin)
      volume += hull_.Volume(std::span(part_points_).subspan(begin, ends[i] - begin));
  return volume;
}

double CutSearch::Score(const Plane& plane) {
  ++evaluations_;
  const std::size_t count = vertices_.size();
  above_.resize(count);
  side_.resize(count);
  double low = 0, high = 0;
  for (std::size_t i = 0; i < count; ++i) {
    above_[i] = plane.Above(vertices_[i]);
    side_[i] = static_cast<signed char>(above_[i] > flat_ ? 1 : above_[i] < -flat_ ? -1 : 0);
    low = std::min(low, above_[i]);
    high = std::max(high, above_[i]);
  }
  if (!(low < -flat_ && high > flat_)) return -1;
  parts_.Reset(2 * count);
  for (const Edge& edge : edges_) {
    const int from = side_[edge.from], to = side_[edge.to];
    if (from + to == 0) continue;
    const auto shift = static_cast<std::uint32_t>(from + to > 0 ? count : 0);
    parts_.Join(edge.from + (from == 0 ? shift : 0), edge.to + (to == 0 ? shift : 0));
  }
  double after = 0;
  for (const int sign : {-1, 1}) {
    const double volume = HullsOf(sign);
    if (volume < 0) return -1;
    after += volume;
  }
  double resolved = 0;
  for (const ConcaveEdge& edge : concave_)
    if (side_[edge.from] == 0 && side_[edge.to] == 0) resolved += edge.weight;
  const double concavity = concavity_ > 0 ? resolved / concavity_ : 0;
  const double balance = std::min(high, -low) / (high - low);
  return std::max(0.0, hull_volume_ - after +
                           defect_ * (kConcavityWeight * concavity + kBalanceWeight * balance));
}

void CutSearch::Try(const Plane& plane) {
  if (evaluations_ >= budget_) return;
  if (const double score = Score(plane); score >= 0) candidates_.push_back({plane, score});
}

void CutSearch::AddAcross() {
  const std::size_t positions = std::clamp<std::size_t>(budget_ / 2 / 13, 1, 19);
  std::vector<Vector3d> directions = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (budget_ > 60)
    directions.insert(directions.end(), {{1, 1, 0},
                                         {1, -1, 0},
                                         {1, 0, 1},
                                         {1, 0, -1},
                                         {0, 1, 1},
                                         {0, 1, -1},
                                         {1, 1, 1},
                                         {1, 1, -1},
                                         {1, -1, 1},
                                         {1, -1, -1}});
  for (Vector3d& direction : directions) {
    direction /= std::sqrt(direction.squaredNorm());
    double low = direction.dot(vertices_[0]), high = low;
    for (const Vector3d& vertex : vertices_) {
      low = std::min(low, direction.dot(vertex));
      high = std::max(high, direction.dot(vertex));
    }
    for (std::size_t i = 1; i <= positions; ++i)
      Try({direction,
           low + (high - low) * static_cast<double>(i) / static_cast<double>(positions + 1)});
  }
}

void CutSearch::AddAlongConcaveEdges() {
  struct FacePlane {
    Plane plane;
    double weight;
  };
  std::vector<FacePlane> faces;
  // The edges come by falling weight; the remaining ones of a fine mesh add little.
  constexpr std::size_t kMostEdges = 2000, kMostFaces = 500;
  for (std::size_t i = 0; i < std::min(concave_.size(), kMostEdges); ++i)
    for (const Plane& face : concave_[i].faces) {
      const auto same = std::find_if(faces.begin(), faces.end(), [&](const FacePlane& other) {
        return std::abs(other.plane.normal.dot(face.normal)) > 1 - 1e-6 &&
               std::abs(other.plane.Above(vertices_[concave_[i].from])) <= flat_ &&
               std::abs(other.plane.Above(vertices_[concave_[i].to])) <= flat_;
      });
      if (same != faces.end())
        same->weight += concave_[i].weight;
      else if (faces.size() < kMostFaces)
        faces.push_back({face, concave_[i].weight});
    }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const FacePlane& a, const FacePlane& b) { return a.weight > b.weight; });
  const std::size_t tried = std::min({faces.size(), kFacePlanes, budget_ / 5});
  for (std::size_t i = 0; i < tried; ++i) Try(faces[i].plane);
  const std::size_t paired = budget_ > 100 ? std::min(concave_.size(), kPairedEdges) : 0;
  for (std::size_t i = 0; i < paired; ++i)
    for (std::size_t k = i + 1; k < paired; ++k) {
      const Vector3d &a = vertices_[concave_[i].from], &b = vertices_[concave_[i].to];
      const Vector3d &c = vertices_[concave_[k].from], &d = vertices_[concave_[k].to];
      const Vector3d along = b - a, over = (c + d) / 2 - (a + b) / 2;
      Vector3d normal = along.cross(over);
      const double length = std::sqrt(normal.squaredNorm());
      if (!(length > flat_ * flat_)) continue;
      normal /= length;
      const Plane plane{normal, normal.dot(a)};
      if (std::abs(plane.Above(c)) <= flat_ && std::abs(plane.Above(d)) <= flat_) Try(plane);
    }
}

/// Moves and tilts a plane as long as that helps.
void CutSearch::Refine(Found best) {
  double low = 0, high = 0;
  for (const Vector3d& vertex : vertices_) {
    low = std::min(low, best.plane.Above(vertex));
    high = std::max(high, best.plane.Above(vertex));
  }
  Vector3d first = best.plane.normal.cross(
      std::abs(best.plane.normal.x()) < 0.7 ? Vector3d(1, 0, 0) : Vector3d(0, 1, 0));
  first /= std::sqrt(first.squaredNorm());
  const Vector3d second = best.plane.normal.cross(first);
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& vertex : vertices_) middle += vertex / static_cast<double>(vertices_.size());
  double shift = (high - low) / 20, tilt = 0.12;
  for (int round = 0; round < 4; ++round, shift /= 2, tilt /= 2) {
    const Plane from = best.plane;
    for (const auto& [along, u, v] : {std::tuple{1.0, 0.0, 0.0},
                                      {-1.0, 0.0, 0.0},
                                      {0.0, 1.0, 0.0},
                                      {0.0, -1.0, 0.0},
                                      {0.0, 0.0, 1.0},
                                      {0.0, 0.0, -1.0}}) {
      if (evaluations_ >= budget_) break;
      Vector3d normal = from.normal + tilt * (u * first + v * second);
      normal /= std::sqrt(normal.squaredNorm());
      // Tilted about the point of the plane next to the middle.
      const Vector3d pivot = middle - from.Above(middle) * from.normal;
      const Plane moved{normal, normal.dot(pivot) + along * shift};
      if (const double score = Score(moved); score > best.score) best = {moved, score};
    }
  }
  candidates_.push_back(best);
}

std::optional<CutSearch::Found> CutSearch::Find(const Piece& piece, std::size_t most) {
  most_ = std::max<std::size_t>(most, 1);
  Prepare(piece);
  AddAlongConcaveEdges();
  AddAcross();
  const auto sort = [&] {
    std::stable_sort(candidates_.begin(), candidates_.end(),
                     [](const Found& a, const Found& b) { return a.score > b.score; });
  };
  sort();
  if (candidates_.empty()) return std::nullopt;
  const std::vector<Found> best(
      candidates_.begin(),
      candidates_.begin() + static_cast<std::ptrdiff_t>(std::min(candidates_.size(), kRefined)));
  for (const Found& candidate : best) Refine(candidate);
  sort();
  return candidates_[0];
}

}  // namespace cdb::meshes
