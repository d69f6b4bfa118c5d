// Whether triangles intersect, and whether a vertex and a triangle, or two edges, meet while each
// of their vertices moves along a line. Exact for every input: touching is a collision, also at the
// ends of the step, and so is an overlap of what is degenerate or remains in one plane.
//
// Nearly all pairs are decided in double, where Bernstein coefficients are farther from 0 than
// rounding can bring them; the others by the roots of polynomials with exact coefficients.
//
// Sources: X. Provot, "Collision and self-collision handling in cloth model dedicated to design
// garments" (Graphics Interface 1997) for the cubic of coplanar vertices; M. Tang, R. Tong, Z. Wang
// and D. Manocha, "Fast and exact continuous collision detection with Bernstein sign
// classification" (ACM Transactions on Graphics 33(6), 2014) for the filter; B. Wang et al., "A
// large-scale benchmark and an inclusion-based algorithm for continuous collision detection" (ACM
// Transactions on Graphics 40(5), 2021) for what has to be true. Threads: any.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

namespace cdb::exact {

/// A vertex and the three of a triangle, or the two of each of two edges.
using FourPoints = std::array<Eigen::Vector3d, 4>;
/// At the start and at the end of a step. All coordinates must be finite.
struct MovingPoints {
  FourPoints from, to;
};

/// True if the first point meets the triangle of the other three at some time of the step.
bool VertexMeetsFace(const MovingPoints& points);
/// True if the edge of the first two points meets that of the last two at some time of the step.
bool EdgesMeet(const MovingPoints& points);

/// True if two triangles have a point in common. All coordinates must be finite.
bool TrianglesMeet(const std::array<Eigen::Vector3d, 3>& a,
                   const std::array<Eigen::Vector3d, 3>& b);

/// The answers of the filters alone; none where rounding could change them.
std::optional<bool> FilterVertexFace(const MovingPoints& points);
std::optional<bool> FilterEdges(const MovingPoints& points);
/// The answers without the filters.
bool DecideVertexFace(const MovingPoints& points);
bool DecideEdges(const MovingPoints& points);

}  // namespace cdb::exact
