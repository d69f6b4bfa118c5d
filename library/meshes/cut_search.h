// The plane along which it is best to cut a piece.
//
// The gain of a cut is the volume by which the convex hulls of the parts are smaller than that of
// the piece. Founds are planes across a few directions, planes of the faces at concave edges,
// and planes through two of these edges; the best are then moved and tilted a little. Of cuts
// without gain, those through concave edges come first: several may be needed before the hulls
// shrink. Lengths in the unit of the mesh. Errors: none. Threads: one at a time for each object.
// Sources: Mamou, "Volumetric hierarchical approximate convex decomposition", Game Engine Gems 3,
// 2016; Wei et al., "Approximate convex decomposition for 3D meshes with collision-aware concavity
// and tree search", ACM TOG 41(4), 2022.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "library/meshes/cut.h"
#include "library/meshes/quick_hull.h"
#include "library/meshes/union_find.h"

namespace cdb::meshes {

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
