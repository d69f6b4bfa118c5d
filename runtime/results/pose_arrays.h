// Poses in an HDF5 file made by the user: datasets `position` (n x 3, m), and optionally
// `orientation` (n x 4, quaternions w, x, y, z), `linear_velocity` (n x 3, m/s) and
// `angular_velocity` (n x 3, rad/s), each in the root of the file.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

namespace cdb::results {

/// The rows of all objects, one after the other; empty if the file has no such dataset.
struct PoseArrays {
  std::vector<double> position, orientation, linear_velocity, angular_velocity;
};

/// Nullopt if the file is HDF5 and has no dataset `position`. Throws StoreError, which names the
/// dataset, for other shapes and types.
std::optional<PoseArrays> ReadPoseArrays(const std::filesystem::path& file);

}  // namespace cdb::results
