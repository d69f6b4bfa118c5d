// Numbers m 2^e with whole m of any length: sums, differences and products of doubles without
// rounding. Threads: any.
#pragma once

#include <cstdint>
#include <vector>

namespace cdb::exact {

class Dyadic {
 public:
  Dyadic() = default;  ///< 0
  /// `value` must be finite.
  explicit Dyadic(double value);

  /// -1, 0 or 1.
  int Sign() const { return digits_.empty() ? 0 : is_negative_ ? -1 : 1; }
  /// The number of 64-bit digits.
  std::size_t Length() const { return digits_.size(); }

  Dyadic operator-() const;
  friend Dyadic operator+(const Dyadic& a, const Dyadic& b) { return Sum(a, b, b.is_negative_); }
  friend Dyadic operator-(const Dyadic& a, const Dyadic& b) { return Sum(a, b, !b.is_negative_); }
  friend Dyadic operator*(const Dyadic& a, const Dyadic& b);

 private:
  static Dyadic Sum(const Dyadic& a, const Dyadic& b, bool is_b_negative);
  std::uint64_t DigitAt(std::int64_t place) const;
  std::int64_t End() const { return place_ + static_cast<std::int64_t>(digits_.size()); }
  void Trim();

  bool is_negative_ = false;
  std::int64_t place_ = 0;             ///< the value of digit i is digits_[i] 2^(64 (place_ + i))
  std::vector<std::uint64_t> digits_;  ///< neither the first nor the last is 0
};

}  // namespace cdb::exact
