// The shapes of a scene, prepared for the narrow phase: each body is a list of convex pieces.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "library/detectors/narrow/vectors.h"

namespace cdb::narrow {

/// m: bodies within this distance get a contact (detector.h).
inline constexpr double kNear = 0.02;

/// kRound: ellipsoids, and capsules on an ellipse. kOther is not handled.
enum class Kind : std::uint8_t {
  kBall,
  kCapsule,
  kBox,
  kHull,
  kCylinder,
  kCone,
  kRound,
  kPlane,
  kOther
};
inline constexpr int kKinds = 9;
inline constexpr bool IsCurved(Kind kind) {
  return kind == Kind::kCylinder || kind == Kind::kCone || kind == Kind::kRound;
}

/// A flat face: its corners are in order, counter-clockwise from outside.
struct FlatFace {
  Vec3 normal;                 ///< unit, outwards
  double offset;               ///< the greatest normal . x of the piece
  std::uint32_t first, count;  ///< of its corners, in Piece::corners
};

/// A convex piece in the frame of its body: a core, and a ball of `radius` that rolls around it.
/// The core of a ball is a point, that of a capsule a segment along y; others have no radius.
struct Piece {
  Kind kind = Kind::kOther;
  double radius = 0;
  /// Of the core of a box, of a capsule along y, of a cylinder or cone along y, and of the
  /// ellipsoid of a kRound.
  Vec3 half = {};
  double straight = 0;  ///< half of the straight part of a kRound, along y
  Vec3 normal = {};     ///< of a plane
  Vec3 centre = {};     ///< of the ball around it
  double bound = 0;     ///< the radius of that ball; infinite for a plane
  double reach = 0;     ///< the radius of a ball about the origin around it
  /// Of the core, or some on the rims of a cylinder or cone; as columns x, y, z of `padded`
  /// numbers, of which the last repeat the first. A vertex of a box has bit 0, 1, 2 set if it is on
  /// the upper side along x, y, z.
  std::uint32_t count = 0, padded = 0;
  std::vector<double> columns = {};
  /// Of boxes, hulls, cylinders (below and above) and cones (below).
  std::vector<FlatFace> faces = {};
  std::vector<std::uint32_t> corners = {};  ///< of all faces: vertices
  /// The normals of all faces of a hull, as the columns of the vertices.
  std::uint32_t padded_faces = 0;
  std::vector<double> face_columns = {};

  Vec3 Vertex(std::uint32_t i) const {
    return {columns[i], columns[padded + i], columns[2 * padded + i]};
  }
};

/// The pieces of a body.
struct BodyPieces {
  const Piece* first = nullptr;
  std::uint32_t count = 0;
  Kind kind = Kind::kOther;  ///< of the pieces; kOther if there are none
  double reach = 0;          ///< the greatest of theirs
};

/// The pieces of every body; equal shapes share them. Threads: any, after Prepare.
class Pieces {
 public:
  void Prepare(const Scene& scene);
  const BodyPieces& Of(Id body) const { return of_body_[body]; }

 private:
  struct Form {
    Shape shape;
    std::unique_ptr<const std::vector<Piece>> pieces;
  };
  std::vector<Form> forms_;
  std::vector<BodyPieces> of_body_;
};

}  // namespace cdb::narrow
