// The depth of two overlapping cores, by a polytope inside their Minkowski difference that grows at
// its face nearest to the origin until that face is on the surface: van den Bergen, Proximity
// queries and penetration depth computation on 3D game objects, 2001. For polytopes the result is
// exact.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "library/detectors/narrow/memory.h"

namespace cdb::narrow {
namespace {

/// Least cosine of the normals of triangles in one plane.
constexpr double kSamePlane = 1 - 1e-10;
/// Faces with normals this close to that of the best point, and this part as far from the origin,
/// are on the way to it, if they are on the same smooth part.
constexpr double kNearby = 0.99, kDeep = 0.99;
constexpr int kMostVertices = 256, kMostFaces = 1024;
/// How much farther than the nearest face the other faces of a kept polytope are, in depths and in
/// radii of the smaller piece, so that they stay so while the pieces move a little.
constexpr double kRoom = 1.2, kMoreRoom = 0.01;

struct Face3 {
  int vertex[3];
  int neighbour[3];  ///< across the side from vertex i to the next,
  int side[3];       ///< which is this side of the neighbour
  Vec3 normal;       ///< unit, outwards, if it has an area
  bool is_alive, has_area;
};

class Polytope {
 public:
  explicit Polytope(const Couple& couple) : couple_(couple) {}

  /// Begins with a tetrahedron of the simplex and other vertices. False if the difference is flat.
  bool Begin(const DifferenceVertex* simplex, int count) {
    std::copy_n(simplex, count, vertices_.begin());
    vertex_count_ = 1;
    // The vertices of the simplex come first; those that add nothing are replaced.
    for (int i = 1; i < count; ++i) {
      vertices_[vertex_count_] = simplex[i];
      if (Adds(simplex[i].at)) ++vertex_count_;
    }
    if (vertex_count_ == 1)
      AddFarthest({1, 0, 0}) || AddFarthest({0, 1, 0}) || AddFarthest({0, 0, 1});
    if (vertex_count_ == 2) {
      const Vec3 across = Across();
      AddFarthest(across) || AddFarthest(Cross(across, At(1) - At(0)));
    }
    if (vertex_count_ == 3) AddFarthest(Across());
    if (vertex_count_ < 4) return false;
    if (Dot(Across(), At(3) - At(0)) > 0) std::swap(vertices_[0], vertices_[1]);
    constexpr int kSides[4][3] = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
    for (const auto& side : kSides) AddFace(side[0], side[1], side[2]);
    Link(0, 0, 1, 2), Link(0, 1, 3, 2), Link(0, 2, 2, 0);
    Link(1, 0, 2, 2), Link(1, 1, 3, 0), Link(2, 1, 3, 1);
    return true;
  }

  /// The face nearest to the origin; -1 if none has an area.
  int NearestFace() const {
    double least = std::numeric_limits<double>::infinity();
    int best = -1;
    for (int i = 0; i < face_count_; ++i)
      if (heights_[i] < least) least = heights_[i], best = i;
    return best;
  }
  /// The points of the cores where the polytope ends along the direction.
  void PointsAlong(const Vec3& direction, Vec3& on_a, Vec3& on_b) const {
    double most = -std::numeric_limits<double>::infinity(), weight[3] = {};
    int best = 0;
    for (int i = 0; i < face_count_; ++i) {
      const Face3& face = faces_[i];
      const double along = face.is_alive && face.has_area ? Dot(face.normal, direction) : 0;
      if (!(along > 0)) continue;
      double of_face[3];
      const double inside = WeightsOf(face, distances_[i] / along * direction, of_face);
      if (inside <= most) continue;
      most = inside;
      best = i;
      std::copy_n(of_face, 3, weight);
    }
    Mix(faces_[best], weight, on_a, on_b);
  }
  /// The face is not the nearest one from now on.
  void PassOver(int face) { heights_[face] = std::numeric_limits<double>::infinity(); }

  /// Grows at the face to include a vertex beyond it. False if there is no room, or if rounding
  /// hides the outline of what is seen from the vertex.
  bool Grow(int face, const DifferenceVertex& vertex) {
    if (vertex_count_ == kMostVertices) return false;
    apex_ = vertex_count_++;
    vertices_[apex_] = vertex;
    first_new_ = last_new_ = -1;
    new_count_ = 0;
    const Face3 start = faces_[face];
    Remove(face);
    for (int side = 0; side < 3; ++side)
      if (!Visit(start.neighbour[side], start.side[side])) return false;
    // Their places may be taken once nothing refers to them.
    std::copy_n(removed_.begin(), removed_count_, free_.begin() + free_count_);
    free_count_ += std::exchange(removed_count_, 0);
    return new_count_ >= 3 && LinkNew(last_new_, first_new_);
  }

  /// A direction across the vertices, of which there are fewer than four.
  Vec3 Across() const {
    if (vertex_count_ == 1) return {0, 1, 0};
    if (vertex_count_ == 2) return UnitAcross(At(1) - At(0));
    return Cross(At(1) - At(0), At(2) - At(0));
  }
  const Vec3& NormalOf(int face) const { return faces_[face].normal; }
  double DistanceOf(int face) const { return distances_[face]; }

  /// The points of the cores where the plane of the face is nearest to the origin: of the triangles
  /// in that plane, one contains it.
  void Nearest(int i, Vec3& on_a, Vec3& on_b) const {
    const Vec3 foot = distances_[i] * faces_[i].normal;
    double most = -std::numeric_limits<double>::infinity(), weight[3] = {};
    int best = i;
    for (int k = 0; k < face_count_; ++k) {
      if (!(distances_[k] <= distances_[i] + Thin()) ||
          Dot(faces_[k].normal, faces_[i].normal) < kSamePlane)
        continue;
      double of_face[3];
      const double inside = WeightsOf(faces_[k], foot, of_face);
      if (inside <= most) continue;
      most = inside;
      best = k;
      std::copy_n(of_face, 3, weight);
    }
    Mix(faces_[best], weight, on_a, on_b);
  }

  const DifferenceVertex& CornerOf(int face, int k) const {
    return vertices_[faces_[face].vertex[k]];
  }

  /// Grows until the faces that are not on the surface are farther from the origin than `enough`,
  /// as far as there is room, and keeps the surface. To be called last.
  void Keep(double enough, Shell& shell) {
    shell.vertex_count = 0;
    for (;;) {
      const int nearest = NearestFace();
      if (nearest < 0 || distances_[nearest] >= enough) break;
      const DifferenceVertex vertex = couple_.Support(NormalOf(nearest));
      if (Dot(vertex.at, NormalOf(nearest)) - distances_[nearest] <= couple_.skin) {
        PassOver(nearest);
      } else if (vertex_count_ >= static_cast<int>(Shell::kMostVertices)) {
        break;
      } else if (!Grow(nearest, vertex)) {
        return;
      }
    }
    std::array<std::uint8_t, kMostVertices> number;
    number.fill(Shell::kMostVertices);
    std::uint32_t vertices = 0, faces = 0;
    for (int i = 0; i < face_count_; ++i) {
      if (!faces_[i].is_alive) continue;
      if (!faces_[i].has_area || faces == Shell::kMostFaces) return;
      for (int k = 0; k < 3; ++k) {
        const int vertex = faces_[i].vertex[k];
        std::uint8_t& at = number[static_cast<std::size_t>(vertex)];
        if (at == Shell::kMostVertices) {
          if (vertices == Shell::kMostVertices) return;
          shell.of_a[vertices] = static_cast<std::uint16_t>(vertices_[vertex].vertex_a);
          shell.of_b[vertices] = static_cast<std::uint16_t>(vertices_[vertex].vertex_b);
          at = static_cast<std::uint8_t>(vertices++);
        }
        shell.corners[faces][k] = at;
      }
      ++faces;
    }
    shell.vertex_count = static_cast<std::uint8_t>(vertices);
    shell.face_count = static_cast<std::uint8_t>(faces);
  }

  /// Of the corners of the face.
  Edges EdgesOf(int face) const {
    const int* corners = faces_[face].vertex;
    return {couple_, vertices_[corners[0]], vertices_[corners[1]], vertices_[corners[2]]};
  }

 private:
  const Vec3& At(int i) const { return vertices_[i].at; }
  /// m: a height below this is no height.
  double Thin() const { return 1e3 * couple_.rounding; }
  double HeightAbove(int from, int to, const Vec3& at) const {
    const Vec3 along = At(to) - At(from);
    return Norm(Cross(along, at - At(from))) / Norm(along);
  }
  /// Whether the point is not in the point, line or plane of the vertices.
  bool Adds(const Vec3& at) const {
    if (vertex_count_ == 1) return Norm(at - At(0)) > Thin();
    if (vertex_count_ == 2) return HeightAbove(0, 1, at) > Thin();
    return std::abs(Dot(Normalized(Across()), at - At(0))) > Thin();
  }
  /// Adds the farthest vertex in a direction or its opposite, if it is a new one.
  bool AddFarthest(const Vec3& direction) {
    for (const Vec3& way : {direction, -direction}) {
      vertices_[vertex_count_] = couple_.Support(way);
      if (!Adds(At(vertex_count_))) continue;
      ++vertex_count_;
      return true;
    }
    return false;
  }

  /// The weights of the corners whose sum is the point, none of them negative. Returns the least
  /// before that.
  double WeightsOf(const Face3& face, const Vec3& foot, double* weight) const {
    double least = std::numeric_limits<double>::infinity(), sum = 0, area = 0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 next = At(face.vertex[(k + 1) % 3]) - foot,
                 last = At(face.vertex[(k + 2) % 3]) - foot;
      weight[k] = Dot(face.normal, Cross(next, last));
      area += weight[k];
      least = std::min(least, weight[k]);
      weight[k] = std::max(0.0, weight[k]);
      sum += weight[k];
    }
    for (int k = 0; k < 3; ++k) weight[k] = sum > 0 ? weight[k] / sum : 1.0 / 3;
    return area > 0 ? least / area : -std::numeric_limits<double>::infinity();
  }

  /// The points of the cores at the weighted mean of the corners.
  void Mix(const Face3& face, const double* weight, Vec3& on_a, Vec3& on_b) const {
    on_a = on_b = {};
    for (int k = 0; k < 3; ++k) {
      const DifferenceVertex& corner = vertices_[face.vertex[k]];
      on_a = on_a + weight[k] * corner.on_a;
      on_b = on_b + weight[k] * corner.on_b;
    }
  }

  /// In the place of a removed one, if there is any. -1 if there is no room.
  int AddFace(int a, int b, int c) {
    if (free_count_ == 0 && face_count_ == kMostFaces) return -1;
    const int index = free_count_ > 0 ? free_[--free_count_] : face_count_++;
    Face3& face = faces_[index];
    face.vertex[0] = a, face.vertex[1] = b, face.vertex[2] = c;
    face.is_alive = true;
    const Vec3 ab = At(b) - At(a), ac = At(c) - At(a), across = Cross(ab, ac);
    const double area = SquaredNorm(across), longest = std::max(SquaredNorm(ab), SquaredNorm(ac));
    face.has_area = area > 1e-26 * longest * longest && area > 0;
    if (face.has_area) face.normal = 1 / std::sqrt(area) * across;
    heights_[index] = distances_[index] =
        face.has_area ? Dot(face.normal, At(a)) : std::numeric_limits<double>::infinity();
    return index;
  }
  void Remove(int index) {
    faces_[index].is_alive = false;
    heights_[index] = distances_[index] = std::numeric_limits<double>::infinity();
    removed_[removed_count_++] = index;
  }

  void Link(int one, int side, int other, int other_side) {
    faces_[one].neighbour[side] = other;
    faces_[one].side[side] = other_side;
    faces_[other].neighbour[other_side] = one;
    faces_[other].side[other_side] = side;
  }
  /// Two faces at the apex, one after the other around the outline. Side 0 is in the outline.
  bool LinkNew(int one, int next) {
    if (faces_[one].vertex[1] != faces_[next].vertex[0]) return false;
    Link(one, 1, next, 2);
    return true;
  }

  /// Removes the face, which was reached over `side`, and those around it if the apex sees it;
  /// otherwise the side is part of the outline, and gets a new face.
  bool Visit(int index, int side) {
    const Face3& face = faces_[index];
    if (!face.is_alive) return true;
    const int from = face.vertex[side], to = face.vertex[(side + 1) % 3];
    const bool is_seen =
        !face.has_area || Dot(face.normal, At(apex_)) - distances_[index] > couple_.rounding;
    if (!is_seen && !IsInLine(from, to)) {
      const int made = AddFace(to, from, apex_);
      if (made < 0) return false;
      Link(made, 0, index, side);
      const int last = last_new_;
      last_new_ = made;
      if (new_count_++ > 0) return LinkNew(last, made);
      first_new_ = made;
      return true;
    }
    Remove(index);
    for (int k = 1; k < 3; ++k) {
      const int next = (side + k) % 3;
      if (!Visit(face.neighbour[next], face.side[next])) return false;
    }
    return true;
  }
  /// The apex is on the line through two vertices.
  bool IsInLine(int from, int to) const {
    const Vec3 along = At(to) - At(from), across = Cross(along, At(apex_) - At(from));
    return SquaredNorm(across) <= Thin() * Thin() * SquaredNorm(along);
  }

  const Couple& couple_;
  std::array<DifferenceVertex, kMostVertices> vertices_;
  std::array<Face3, kMostFaces> faces_;
  std::array<double, kMostFaces> distances_;  ///< of their planes; infinite if one is none
  std::array<double, kMostFaces> heights_;    ///< the same, but infinite for those passed over
  std::array<int, kMostFaces> free_, removed_;
  int vertex_count_ = 0, face_count_ = 0, free_count_ = 0, removed_count_ = 0;
  int apex_ = 0, first_new_ = 0, last_new_ = 0, new_count_ = 0;
};

}  // namespace

Separation Expand(const Couple& couple, const DifferenceVertex* simplex, int count,
                  const Guess& guess, Memory* memory) {
  Polytope polytope(couple);
  if (!polytope.Begin(simplex, count)) {
    const Vec3 normal = Normalized(polytope.Across());
    Separation flat = {normal, couple.Gap(normal), simplex[0].on_a, simplex[0].on_b};
    if (couple.is_curved) Polish(couple, {}, 8, flat);
    return flat;
  }
  Separation best = guess.separation;
  // Whether the best is the least extent of a smooth part of the difference, and which part.
  bool is_least = guess.is_least;
  Edge patch = guess.edge;
  int nearest = -1;
  const auto remember = [&] {
    if (memory == nullptr) return;
    DifferenceVertex corners[3];
    const int known = nearest < 0 ? 0 : 3;
    for (int k = 0; k < known; ++k) corners[k] = polytope.CornerOf(nearest, k);
    if (SetFeatures(couple, corners, known, memory->features, best) && !couple.is_curved)
      polytope.Keep(kRoom * -best.gap + kMoreRoom * std::min(couple.a.bound, couple.b.bound),
                    memory->shell);
  };
  for (;;) {
    nearest = polytope.NearestFace();
    if (nearest < 0) break;
    const Vec3 normal = polytope.NormalOf(nearest);
    // No face is nearer than the best point of a curved surface, nor is any other point of it.
    if (couple.is_curved && -best.gap - polytope.DistanceOf(nearest) <= couple.skin) break;
    DifferenceVertex vertex = couple.Support(normal);
    const double extent = Dot(vertex.at, normal);
    const bool is_surface = extent - polytope.DistanceOf(nearest) <= couple.skin;
    if (-extent > best.gap || is_surface)
      is_least = false, best = {-normal, -extent, vertex.on_a, vertex.on_b};
    if (is_surface) polytope.Nearest(nearest, best.on_a, best.on_b);
    if (couple.is_curved) {
      const Edges edges = polytope.EdgesOf(nearest);
      const Edge& edge = edges.of[0];
      const bool is_same = is_least && edges.count < 2 && edge.piece == patch.piece;
      if (is_same && Dot(normal, -best.normal) > kNearby &&
          polytope.DistanceOf(nearest) > kDeep * -best.gap) {
        polytope.PassOver(nearest);
        continue;
      }
      if (!is_same && edges.count < 2) {
        Separation polished = {-normal, -extent, vertex.on_a, vertex.on_b};
        if (is_surface) polished = best;
        const Polished found = Polish(couple, edge, 4, polished);
        if (polished.gap > best.gap) best = polished, is_least = found.is_least, patch = edge;
        const DifferenceVertex& other = found.vertex;
        if (Dot(other.at, normal) > polytope.DistanceOf(nearest) + couple.skin) vertex = other;
      }
    }
    if (is_surface) {
      remember();
      return best;
    }
    if (!polytope.Grow(nearest, vertex)) break;
  }
  // The farthest vertex of a curved surface is not the point below the origin.
  if (couple.is_curved && !is_least && !Polish(couple, {}, 8, best).is_least)
    polytope.PointsAlong(-best.normal, best.on_a, best.on_b);
  if (couple.is_curved) remember();
  return best;
}

}  // namespace cdb::narrow
