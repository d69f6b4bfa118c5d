// What is kept of two polytopes that are near each other or overlap, from one cycle to the next, so
// that their separation need not be searched for again: it is computed from the features that gave
// it before, and proven.
#pragma once

#include <cstdint>

#include "library/detectors/narrow/couple.h"

namespace cdb::narrow {

/// The features of two polytopes that give their separation: a face of one, two edges, or less.
struct Features {
  enum class Kind : std::uint8_t {
    kNone,
    kFaceOfA,  ///< with the vertex of b that is deepest behind it
    kFaceOfB,
    kEdges,   ///< one of each, which are not parallel
    kPoints,  ///< two vertices, or a vertex and an edge; only of polytopes that are apart
  };
  Kind kind = Kind::kNone;
  bool is_opposite = false;    ///< the normal is against the product of the edges
  std::uint16_t face = 0;      ///< in Piece::faces
  std::uint16_t of_a[2] = {};  ///< ascending vertices; the same twice for a single one
  std::uint16_t of_b[2] = {};
};

/// A closed surface of triangles around the origin, whose corners are vertices of the difference of
/// two polytopes: the overlap is nowhere less than its distance from the origin.
struct Hull3 {
  static constexpr std::uint32_t kMostVertices = 24, kMostFaces = 2 * kMostVertices - 4;
  std::uint8_t vertex_count = 0;  ///< 0: none
  std::uint8_t face_count = 0;
  std::uint16_t of_a[kMostVertices], of_b[kMostVertices];
  std::uint8_t corners[kMostFaces][3];  ///< counter-clockwise from outside
};

struct Memory {
  Features features;
  Hull3 hull;
};

/// The features of the simplex of `count` vertices in which the difference of two polytopes is
/// nearest to the origin, and the separation that they give, in place of `separation`, which it is
/// but for rounding. It depends on the features and the couple alone, whatever way led to them;
/// only the points do not where features are parallel, so that the nearest are not in them. If
/// there are no features that give it, returns false and changes nothing.
bool SetFeatures(const Couple& couple, const DifferenceVertex* simplex, int count,
                 Features& features, Separation& separation);

/// What Recall finds.
struct Recalled {
  Separation separation;
  bool is_proven = false;   ///< to the bit what Separate finds; otherwise it means nothing
  bool has_points = false;  ///< the same of its points; otherwise they mean nothing
};

/// The separation of the cores, if the features of an earlier cycle give it and that can be proven
/// without a search. If they are farther apart than `reach`, the normal and gap are those of an
/// axis along which they are.
Recalled Recall(const Couple& couple, const Memory& memory, double reach);

}  // namespace cdb::narrow
