// Meshes that several tests use.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "library/meshes/mesh.h"
#include "library/scene_error.h"

namespace cdb::tests {

meshes::Mesh BoxMesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high);
/// An octahedron whose triangles are divided into four `halvings` times, with the vertices on the
/// sphere.
meshes::Mesh SphereMesh(double radius, int halvings);
/// The union of two boxes as one closed surface: 2 x 2 x 1 without the quarter where x, y > 1.
/// Volume 3.
meshes::Mesh AngleMesh();
meshes::Mesh Joined(const meshes::Mesh& a, const meshes::Mesh& b);
meshes::Mesh InsideOut(meshes::Mesh mesh);
meshes::Mesh Moved(meshes::Mesh mesh, const Eigen::Matrix3d& matrix, const Eigen::Vector3d& by);

std::string ToOff(const meshes::Mesh& mesh);
std::string ToObj(const meshes::Mesh& mesh);
std::string ToPly(const meshes::Mesh& mesh);
/// Writes doubles, with a property and an element that readers must skip.
std::string ToBinaryPly(const meshes::Mesh& mesh, bool big_endian);
std::string ToStl(const meshes::Mesh& mesh);
/// Rounds the coordinates to float.
std::string ToBinaryStl(const meshes::Mesh& mesh);

/// The message of the SceneError that `call` throws. If it throws none, the test fails and the
/// result is empty.
template <typename Call>
std::string Refusal(const Call& call) {
  try {
    call();
  } catch (const library::SceneError& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was refused";
  return "";
}

}  // namespace cdb::tests
