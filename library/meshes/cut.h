// Pieces of a solid, cut by planes.
//
// A piece is a closed surface: triangles of the mesh, clipped exactly, and flat caps. A cap is the
// fan of its boundary about one corner; its triangles may overlap with opposite orientations, but
// their winding numbers are those of the section, also if the section is not simple. So volumes are
// exact, and the vertices of a piece have the convex hull of the piece. Vertices within `flat` of a
// plane are on it. Lengths in the unit of the mesh. Errors: none. Threads: any. Deterministic.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "library/meshes/mesh.h"
#include "library/meshes/quick_hull.h"
#include "library/meshes/union_find.h"

namespace cdb::meshes {

struct Plane {
  Eigen::Vector3d normal;  ///< of length 1
  double offset;
  double Above(const Eigen::Vector3d& p) const { return normal.dot(p) - offset; }
};

/// Of a line along which the winding number is not 0 or 1, the part in a piece.
struct Excess {
  Eigen::Vector3d from, to;
  double area;  ///< of the cell round it, times the number by which a volume integral is too large
};

struct Piece {
  Mesh mesh;
  std::vector<std::int32_t> caps;  ///< by triangle: the number of the cut that it caps, or kSurface
  std::vector<Excess> excesses;
  double volume = 0;                     ///< where the winding number is 1 or more
  std::vector<Eigen::Vector3d> corners;  ///< of its convex hull
  double hull_volume = 0;
  /// The volume by which its hull would be too large.
  double Defect() const { return hull_volume - volume; }
};

inline constexpr std::int32_t kSurface = -1;

/// The volume within the surface less the excesses.
double VolumeOf(const Piece& piece);

/// The triangles with equal labels as pieces of their own; the whole if these would be more than
/// `most`, or if one is a cavity. Parts below `least_volume` are dropped. Sets the volumes, but not
/// the hulls.
std::vector<Piece> Separated(const Piece& piece, std::span<const std::uint32_t> labels,
                             double least_volume, std::size_t most);

/// The connected pieces on both sides; `least_volume` and `most` as above, for each side. `cut`: a
/// number, another one for each plane.
std::vector<Piece> Cut(const Piece& piece, const Plane& plane, std::int32_t cut, double flat,
                       double least_volume, std::size_t most);

/// The two as one piece, without the caps between them. Its hull is not set.
Piece Joined(const Piece& first, const Piece& second);

inline constexpr std::uint32_t kNoVertex = 0xffffffff;

// The plane along which it is best to cut a piece.
//
// The gain of a cut is the volume by which the convex hulls of the parts are smaller than that of
// the piece. Candidates are planes across a few directions, planes of the faces at concave edges,
// and planes through two of these edges; the best are then moved and tilted a little. Of cuts
// without gain, those through concave edges come first: several may be needed before the hulls
// shrink. Lengths in the unit of the mesh. Errors: none. Threads: one at a time for each object.
// Sources: Mamou, "Volumetric hierarchical approximate convex decomposition", Game Engine Gems 3,
// 2016; Wei et al., "Approximate convex decomposition for 3D meshes with collision-aware concavity
// and tree search", ACM TOG 41(4), 2022.

class CutSearch {
 public:
  /// Vertices within `flat` of a plane are on it.
  explicit CutSearch(double flat) : flat_(flat) {}

  struct Found {
    Plane plane;
    /// By which the hulls shrink, with a little for concave edges that disappear.
    double score;
  };
  /// `most`: of the parts of one side, or else they count as one. Nullopt if no plane cuts it.
  std::optional<Found> Find(const Piece& piece, std::size_t most);

 private:
  struct Edge {
    std::uint32_t from, to;
    bool is_convex;
  };
  /// Between two triangles of the surface.
  struct ConcaveEdge {
    std::uint32_t from, to;
    double weight;  ///< length times the sine of the angle
    std::array<Plane, 2> faces;
  };

  void Prepare(const Piece& piece);
  void AddEdge(const Piece& piece, std::span<const std::array<std::uint32_t, 4>> sides);
  /// The score of a plane; negative if it does not cut.
  double Score(const Plane& plane);
  double HullsOf(int sign);
  void Collect(int sign);
  void AddAcross();
  void AddAlongConcaveEdges();
  void Try(const Plane& plane);
  void Refine(Found candidate);

  double flat_;
  std::size_t most_ = 1, evaluations_ = 0, budget_ = 0;
  double hull_volume_ = 0, defect_ = 0, concavity_ = 0;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<char> is_corner_;  ///< by vertex: it may be a corner of a part's hull
  std::vector<Edge> edges_;
  std::vector<ConcaveEdge> concave_;
  std::vector<Found> candidates_;

  // Of the plane that is tried.
  std::vector<double> above_;
  std::vector<signed char> side_;
  UnionFind parts_{0};
  /// Points of one side, with the part that they are of.
  std::vector<std::pair<std::uint32_t, Eigen::Vector3d>> points_;
  std::vector<Eigen::Vector3d> part_points_;
  QuickHull hull_;
};

}  // namespace cdb::meshes
