// Descriptions of surfaces, from which pages draw shapes and detectors get hulls.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace cdb::shapes {

/// A point of a profile in the half plane x >= 0, with its normal.
struct ProfilePoint {
  double x, y, normal_x, normal_y;
};
/// A smooth section of the profile of a solid of revolution about y, from the bottom up.
using Profile = std::vector<ProfilePoint>;

/// A flat face: its corners, counter-clockwise from outside.
using FlatFace = std::vector<Eigen::Vector3d>;

}  // namespace cdb::shapes
