#include "library/exact/dyadic.h"

#include <algorithm>
#include <cmath>

namespace cdb::exact {
namespace {

__extension__ using Wide = unsigned __int128;
constexpr int kDigitBits = 64;

}  // namespace

Dyadic::Dyadic(double value) {
  if (value == 0) return;
  int exponent = 0;
  constexpr int kMantissaBits = 53;
  const double fraction = std::frexp(std::abs(value), &exponent);
  const auto mantissa = static_cast<std::uint64_t>(std::ldexp(fraction, kMantissaBits));
  exponent -= kMantissaBits;
  place_ = exponent >= 0 ? exponent / kDigitBits : -((kDigitBits - 1 - exponent) / kDigitBits);
  const Wide shifted = Wide{mantissa} << (exponent - place_ * kDigitBits);
  digits_ = {static_cast<std::uint64_t>(shifted),
             static_cast<std::uint64_t>(shifted >> kDigitBits)};
  is_negative_ = value < 0;
  Trim();
}

Dyadic Dyadic::operator-() const {
  Dyadic result = *this;
  result.is_negative_ = !is_negative_;
  return result;
}

std::uint64_t Dyadic::DigitAt(std::int64_t place) const {
  return place < place_ || place >= End() ? 0 : digits_[static_cast<std::size_t>(place - place_)];
}

void Dyadic::Trim() {
  while (!digits_.empty() && digits_.back() == 0) digits_.pop_back();
  const auto first = std::ranges::find_if(digits_, [](std::uint64_t digit) { return digit != 0; });
  place_ += first - digits_.begin();
  digits_.erase(digits_.begin(), first);
  if (digits_.empty()) *this = {};
}

Dyadic Dyadic::Sum(const Dyadic& a, const Dyadic& b, bool is_b_negative) {
  if (a.Sign() == 0) {
    Dyadic result = b;
    result.is_negative_ = is_b_negative;
    return result;
  }
  if (b.Sign() == 0) return a;
  const bool is_sum = a.is_negative_ == is_b_negative;
  const std::int64_t begin = std::min(a.place_, b.place_), end = std::max(a.End(), b.End());
  bool is_swapped = false;  // the larger magnitude comes first in a difference
  for (std::int64_t place = end - 1; !is_sum && place >= begin; --place) {
    const std::uint64_t digit_a = a.DigitAt(place), digit_b = b.DigitAt(place);
    if (digit_a == digit_b) continue;
    is_swapped = digit_a < digit_b;
    break;
  }
  const Dyadic &larger = is_swapped ? b : a, &smaller = is_swapped ? a : b;
  Dyadic result;
  result.is_negative_ = is_swapped ? is_b_negative : a.is_negative_;
  result.place_ = begin;
  result.digits_.reserve(static_cast<std::size_t>(end - begin) + 1);
  std::uint64_t carry = 0;
  for (std::int64_t place = begin; place < end; ++place) {
    const Wide x = larger.DigitAt(place), y = smaller.DigitAt(place);
    const Wide digit = is_sum ? x + y + carry : x - y - carry;
    result.digits_.push_back(static_cast<std::uint64_t>(digit));
    carry = static_cast<std::uint64_t>(digit >> kDigitBits) & 1;
  }
  if (is_sum) result.digits_.push_back(carry);
  result.Trim();
  return result;
}

Dyadic operator*(const Dyadic& a, const Dyadic& b) {
  if (a.Sign() == 0 || b.Sign() == 0) return {};
  Dyadic result;
  result.is_negative_ = a.is_negative_ != b.is_negative_;
  result.place_ = a.place_ + b.place_;
  result.digits_.resize(a.digits_.size() + b.digits_.size());
  for (std::size_t i = 0; i < a.digits_.size(); ++i) {
    std::uint64_t carry = 0;
    for (std::size_t j = 0; j < b.digits_.size(); ++j) {
      const Wide digit = Wide{a.digits_[i]} * b.digits_[j] + result.digits_[i + j] + carry;
      result.digits_[i + j] = static_cast<std::uint64_t>(digit);
      carry = static_cast<std::uint64_t>(digit >> kDigitBits);
    }
    result.digits_[i + b.digits_.size()] = carry;
  }
  result.Trim();
  return result;
}

}  // namespace cdb::exact
