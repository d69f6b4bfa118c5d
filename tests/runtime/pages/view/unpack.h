// Unpacks arrays as a page does, for tests.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::tests {

inline std::string DecodeBase64(const std::string& text) {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int n = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<std::uint32_t>(kDigits.find(c));
    if ((n += 6) < 8) continue;
    n -= 8;
    bytes += static_cast<char>(bits >> n & 255);
  }
  return bytes;
}

template <typename Value>
std::vector<Value> Unpack(const std::string& text) {
  const std::string bytes = DecodeBase64(text);
  std::vector<Value> values(bytes.size() / sizeof(Value));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(Value));
  return values;
}

inline Eigen::Quaterniond UnpackQuaternion(const std::uint16_t* words) {
  const int largest = (words[0] >> 15) * 2 + (words[1] >> 15);
  Eigen::Vector4d c = Eigen::Vector4d::Zero();
  for (int i = 0; i < 4; ++i)
    if (i != largest) c[i] = ((*words++ & 0x7fff) / 32767.0 * 2 - 1) / std::numbers::sqrt2;
  c[largest] = std::sqrt(std::max(1 - c.squaredNorm(), 0.0));
  return Eigen::Quaterniond(c);
}

}  // namespace cdb::tests
