#include "runtime/pages/view/packing.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

namespace cdb::view {
namespace {

static_assert(std::endian::native == std::endian::little);

template <typename Value>
std::string PackValues(std::span<const Value> values) {
  return Base64(std::as_bytes(values));
}

}  // namespace

std::string Base64(std::span<const std::byte> bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < n ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) text += k <= n ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string PackFloats(std::span<const double> values) {
  std::vector<float> floats;
  floats.reserve(values.size());
  for (const double value : values) floats.push_back(static_cast<float>(value));
  return PackValues(std::span<const float>(floats));
}
std::string PackInts(std::span<const std::int32_t> values) { return PackValues(values); }
std::string PackShorts(std::span<const std::uint16_t> values) { return PackValues(values); }

std::array<std::uint16_t, 3> PackQuaternion(const Eigen::Quaterniond& q, bool flag) {
  Eigen::Vector4d c = q.coeffs();  // x y z w
  if (!c.allFinite() || !(c.norm() > 0)) c = {0, 0, 0, 1};
  c.normalize();
  int largest = 0;
  c.cwiseAbs().maxCoeff(&largest);
  if (c[largest] < 0) c = -c;  // the same rotation
  std::array<std::uint16_t, 3> words{};
  std::size_t word = 0;
  for (int i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const double unit = std::clamp(c[i] * std::numbers::sqrt2, -1.0, 1.0);
    words[word++] = static_cast<std::uint16_t>(std::lround((unit + 1) / 2 * 32767));
  }
  const auto top = [](std::uint16_t value, bool bit) {
    return static_cast<std::uint16_t>(value | (bit ? 0x8000 : 0));
  };
  words[0] = top(words[0], (largest & 2) != 0);
  words[1] = top(words[1], (largest & 1) != 0);
  words[2] = top(words[2], flag);
  return words;
}

}  // namespace cdb::view
