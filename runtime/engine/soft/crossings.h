// Links of a mesh that pierce its triangles.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "compiler/analysis/soft.h"

namespace cdb::soft {

/// The number of links that have a point inside a triangle, with which they share no node, and an
/// end on each side of its plane. `nodes`: positions, finite. In double; a link that only touches a
/// triangle, or lies in its plane, does not count. Threads: any.
std::size_t CountCrossings(const analysis::SoftMesh& mesh, std::span<const Eigen::Vector3d> nodes);

}  // namespace cdb::soft
