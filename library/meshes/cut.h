// Pieces of a solid, cut by planes.
//
// A piece is a closed surface: triangles of the mesh, clipped exactly, and flat caps. A cap is the
// fan of its boundary about one corner; its triangles may overlap with opposite orientations, but
// their winding numbers are those of the section, also if the section is not simple. So volumes are
// exact, and the vertices of a piece have the convex hull of the piece. Vertices within `flat` of a
// plane are on it. Lengths in the unit of the mesh. Errors: none. Threads: any. Deterministic.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "library/meshes/mesh.h"

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

}  // namespace cdb::meshes
