// Packs numbers as text for a page: little-endian, in base64.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace cdb::view {

std::string Base64(std::span<const std::byte> bytes);
/// 4 bytes each; a value beyond float32 becomes infinite.
std::string PackFloats(std::span<const double> values);
std::string PackInts(std::span<const std::int32_t> values);
std::string PackShorts(std::span<const std::uint16_t> values);

/// A unit quaternion in 48 bits: three words of 15 bits for the components without the largest one,
/// in the order x y z w, each from -1/sqrt(2) to 1/sqrt(2). The top bits of the first two words
/// have the index of the largest component, that of the third has `flag`. The components are exact
/// to kQuaternionError. A quaternion that is not finite becomes the identity.
std::array<std::uint16_t, 3> PackQuaternion(const Eigen::Quaterniond& q, bool flag);
inline constexpr double kQuaternionError = 2.2e-5;

}  // namespace cdb::view
