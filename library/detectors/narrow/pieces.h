// The shapes of a scene, prepared for the narrow phase: each body is a list of convex pieces.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "library/detectors/narrow/vectors.h"

namespace cdb::narrow {

/// m: bodies within this distance get a contact (detector.h).
inline constexpr double kNear = 0.02;

/// In the order of the table of kernels.
enum class Kind : std::uint8_t { kBall, kCapsule, kBox, kHull, kPlane, kOther };
inline constexpr int kKinds = 5;  ///< that are handled

/// A flat face: its corners are in order, counter-clockwise from outside.
struct FlatFace {
  Vec3 normal;    ///< unit, outwards
  double offset;  ///< the greatest normal . x of the piece
  std::uint32_t first, count;  ///< of its corners, in Piece::corners
};

/// A convex piece in the frame of its body: a core, and a ball of `radius` that rolls around it.
/// The core of a ball is a point, that of a capsule a segment along y; boxes and hulls have no
/// radius.
struct Piece {
  Kind kind = Kind::kOther;
  double radius = 0;
  Vec3 half = {};    ///< of the core of a box, or of a capsule along y
  Vec3 normal = {};  ///< of a plane
  Vec3 centre = {};  ///< of the ball around it
  double bound = 0;  ///< the radius of that ball; infinite for a plane
  /// Of the core, as columns x, y, z of `padded` numbers, of which the last repeat the first. A
  /// vertex of a box has bit 0, 1, 2 set if it is on the upper side along x, y, z.
  std::uint32_t count = 0, padded = 0;
  std::vector<double> columns = {};
  std::vector<FlatFace> faces = {};          ///< of boxes and hulls
  std::vector<std::uint32_t> corners = {};  ///< of all faces: vertices

  Vec3 Vertex(std::uint32_t i) const {
    return {columns[i], columns[padded + i], columns[2 * padded + i]};
  }
};

/// The pieces of every body; equal shapes share them. Threads: any, after Prepare.
class Pieces {
 public:
  void Prepare(const Scene& scene);
  /// Empty if the shape is not handled.
  std::span<const Piece> Of(Id body) const { return *of_body_[body]; }
  /// kOther if the shape is not handled; the kind of the pieces of a compound is kHull.
  Kind KindOf(Id body) const { return kind_[body]; }
  std::size_t size() const { return of_body_.size(); }

 private:
  struct Form {
    Shape shape;
    std::unique_ptr<const std::vector<Piece>> pieces;
  };
  std::vector<Form> forms_;
  std::vector<const std::vector<Piece>*> of_body_;
  std::vector<Kind> kind_;
};

}  // namespace cdb::narrow
