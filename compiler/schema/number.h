// Numbers of the language: integers are exact.
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace cdb::schema {

__extension__ using Integer = __int128;

/// An integer or a real. Sums, differences, products and powers of integers are integers, and so
/// are quotients without a remainder; results beyond 64 bits become 64-bit reals. In a plan, a
/// count is an integer and any other number a real.
class Number {
 public:
  /// Implicit, so that settings accept C++ numbers.
  Number(std::uint64_t value) : value_(Integer{value}) {}
  Number(double value) : value_(value) {}
  static Number Whole(Integer value);
  /// A literal of the language; nullopt if it does not fit.
  static std::optional<Number> FromLiteral(std::string_view text);

  bool is_whole() const { return std::holds_alternative<Integer>(value_); }
  /// Also of a real without a fraction, up to 2^53: `1e6` is a count.
  std::optional<Integer> AsWhole() const;
  /// Anything but an integer from 0 to 2^64 - 1 is an internal error (CDB_CHECK).
  std::uint64_t AsCount() const;
  double AsReal() const {
    return is_whole() ? static_cast<double>(*whole()) : std::get<double>(value_);
  }
  std::string Text() const;

  Number operator-() const;
  friend Number operator+(const Number& a, const Number& b);
  friend Number operator-(const Number& a, const Number& b);
  friend Number operator*(const Number& a, const Number& b);
  friend Number operator/(const Number& a, const Number& b);
  friend Number Power(const Number& base, const Number& exponent);
  /// By value: 1 and 1.0 are equivalent. Exact if both are integers. NaN compares as unordered.
  friend std::partial_ordering Compare(const Number& a, const Number& b);
  /// By representation: the integer 1 differs from the real 1.0.
  bool operator==(const Number&) const = default;

 private:
  const Integer* whole() const { return std::get_if<Integer>(&value_); }

  std::variant<Integer, double> value_;
};

/// The shortest text that reads back to the same double: `0.1`, `1e-09`, `250`.
std::string FormatReal(double value);

}  // namespace cdb::schema
