#include "compiler/schema/number.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "dsl/text/check.h"

namespace cdb::schema {
namespace {

constexpr Integer kMost = Integer{1} << 64;

}  // namespace

Number Number::Whole(Integer value) {
  if (value > kMost || value < -kMost) return Number(static_cast<double>(value));
  Number whole(0.0);
  whole.value_ = value;
  return whole;
}

std::optional<Number> Number::FromLiteral(std::string_view text) {
  std::string digits;
  for (const char c : text)
    if (c != '_') digits += c;
  const bool hex = digits.starts_with("0x") || digits.starts_with("0X");
  if (hex || digits.find_first_of(".eE") == std::string::npos) {
    const char* begin = digits.data() + (hex ? 2 : 0);
    const char* end = digits.data() + digits.size();
    std::uint64_t whole = 0;
    const auto [stop, error] = std::from_chars(begin, end, whole, hex ? 16 : 10);
    if (error == std::errc{} && stop == end) return Whole(whole);
    if (hex) return std::nullopt;
  }
  double real = 0;
  const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), real);
  if (error != std::errc{} || stop != digits.data() + digits.size()) return std::nullopt;
  return Number(real);
}

std::optional<Integer> Number::AsWhole() const {
  if (is_whole()) return *whole();
  // Above 2^53, a real that looks like an integer has lost its last digits.
  const double real = std::get<double>(value_);
  if (std::floor(real) != real || std::fabs(real) > 9007199254740992.0) return std::nullopt;
  return static_cast<Integer>(real);
}

std::uint64_t Number::AsCount() const {
  CDB_CHECK(is_whole() && *whole() >= 0 && *whole() < kMost);
  return static_cast<std::uint64_t>(*whole());
}

std::string Number::Text() const {
  return is_whole() ? fmt::format("{}", *whole()) : FormatReal(std::get<double>(value_));
}

Number Number::operator-() const {
  return is_whole() ? Whole(-*whole()) : Number(-std::get<double>(value_));
}

Number operator+(const Number& a, const Number& b) {
  if (a.is_whole() && b.is_whole()) return Number::Whole(*a.whole() + *b.whole());
  return Number(a.AsReal() + b.AsReal());
}

Number operator-(const Number& a, const Number& b) { return a + -b; }

Number operator*(const Number& a, const Number& b) {
  Integer product = 0;
  if (a.is_whole() && b.is_whole() && !__builtin_mul_overflow(*a.whole(), *b.whole(), &product))
    return Number::Whole(product);
  return Number(a.AsReal() * b.AsReal());
}

Number operator/(const Number& a, const Number& b) {
  if (a.is_whole() && b.is_whole() && *b.whole() != 0 && *a.whole() % *b.whole() == 0)
    return Number::Whole(*a.whole() / *b.whole());
  return Number(a.AsReal() / b.AsReal());
}

Number Power(const Number& base, const Number& exponent) {
  if (base.is_whole() && exponent.is_whole() && *exponent.whole() >= 0 && *exponent.whole() <= 64) {
    Number power = Number::Whole(1);
    for (Integer i = 0; i < *exponent.whole(); ++i) power = power * base;
    return power;
  }
  return Number(std::pow(base.AsReal(), exponent.AsReal()));
}

std::partial_ordering Compare(const Number& a, const Number& b) {
  if (a.is_whole() && b.is_whole())
    return *a.whole() < *b.whole()   ? std::partial_ordering::less
           : *a.whole() > *b.whole() ? std::partial_ordering::greater
                                     : std::partial_ordering::equivalent;
  return a.AsReal() <=> b.AsReal();
}

std::string FormatReal(double value) { return fmt::format("{}", value); }

}  // namespace cdb::schema
