// What is kept of two pieces that are near each other or overlap, from one cycle to the next, so
// that their separation need not be searched for again: it is computed from the features that gave
// it before, and proven.
#pragma once

#include <cstdint>

#include "library/detectors/narrow/couple.h"

namespace cdb::narrow {

/// The features of two pieces that give their separation: a face of one, two edges, or parts of
/// which one is curved. Two polytopes that are nearest at a corner and an edge, or at two corners,
/// have none.
struct Features {
  enum class Kind : std::uint8_t {
    kNone,
    kFaceOfA,  ///< with the vertex of b that is deepest behind it
    kFaceOfB,
    kEdges,    ///< one of each, which are not parallel; of a curved surface, a line on it
    kSmooth,   ///< two curved surfaces, or one and a corner
    kEdgeOfA,  ///< the same with an edge of a, or a line on its curved surface
    kEdgeOfB,
  };
  static constexpr std::uint16_t kAxis = 0xffff;  ///< in place of a vertex: a line along the axis
  Kind kind = Kind::kNone;
  bool is_opposite = false;    ///< the normal is against the product of the edges
  std::uint16_t face = 0;      ///< in Piece::faces
  std::uint16_t of_a[2] = {};  ///< of an edge: vertices, ascending
  std::uint16_t of_b[2] = {};
};

/// A closed surface of triangles around the origin, whose corners are vertices of the difference of
/// two polytopes. No way out of the overlap is shorter than the distance of its nearest triangle
/// from the origin.
struct Shell {
  static constexpr std::uint32_t kMostVertices = 24, kMostFaces = 2 * kMostVertices - 4;
  std::uint8_t vertex_count = 0;  ///< 0: none
  std::uint8_t face_count = 0;
  std::uint16_t of_a[kMostVertices], of_b[kMostVertices];
  std::uint8_t corners[kMostFaces][3];  ///< counter-clockwise from outside
};

struct Memory {
  Features features;
  Shell shell;
};

/// The features of the simplex of `count` vertices in which the difference of two pieces is nearest
/// to the origin, and the separation that they give, in place of `separation`, which it is but for
/// rounding. The simplex may have no vertices: then no pair of edges is found. It depends on the
/// features and the couple alone, whatever way led to them, but for Settled::is_certain; only the
/// points do not where features are parallel, so that the nearest are not in them. False, with
/// Features::Kind::kNone, if no features give it.
bool SetFeatures(const Couple& couple, const DifferenceVertex* simplex, int count,
                 Features& features, Separation& separation);

/// What Recall finds.
struct Recalled {
  Separation separation;
  /// What Separate finds, to the bit where it is exact; otherwise the separation means nothing.
  bool is_proven = false;
  bool has_points = false;  ///< the same of its points; otherwise they mean nothing
};

/// The separation of the cores, if the features of an earlier cycle give it and that can be proven
/// without a search. `axis`: the normal of that cycle. If they are farther apart than `reach`, the
/// normal and gap are those of an axis along which they are.
Recalled Recall(const Couple& couple, const Memory& memory, const Vec3& axis, double reach);

}  // namespace cdb::narrow
