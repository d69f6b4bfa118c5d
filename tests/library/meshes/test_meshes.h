// Meshes that the tests of library/meshes share.
#pragma once

#include <string>
#include <string_view>

#include "library/meshes/mesh.h"

namespace cdb::library::testing {

Mesh BoxMesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high);
/// An octahedron, its triangles in four so often, its vertices on the sphere.
Mesh SphereMesh(double radius, int halvings);
/// Two boxes' union as one closed surface: 2 x 2 x 1 without the quarter where x, y > 1. Volume 3.
Mesh AngleMesh();
Mesh Joined(const Mesh& a, const Mesh& b);
Mesh InsideOut(Mesh mesh);
Mesh Moved(Mesh mesh, const Eigen::Matrix3d& matrix, const Eigen::Vector3d& by);

std::string ToOff(const Mesh& mesh);
std::string ToObj(const Mesh& mesh);
std::string ToPly(const Mesh& mesh);
/// Doubles, with a property and an element that do not matter.
std::string ToBinaryPly(const Mesh& mesh, bool big_endian);
std::string ToStl(const Mesh& mesh);
/// Rounds the coordinates to float.
std::string ToBinaryStl(const Mesh& mesh);

/// The message of the SceneError that `call` throws; a failed test and nothing where it throws
/// none.
template <typename Call>
std::string Refusal(const Call& call);

}  // namespace cdb::library::testing

#include <gtest/gtest.h>

#include "library/scene_error.h"

template <typename Call>
std::string cdb::library::testing::Refusal(const Call& call) {
  try {
    call();
  } catch (const SceneError& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was refused";
  return "";
}
