// What an expression evaluates to, before a parameter says what it must be.
#pragma once

#include <Eigen/Core>
#include <compare>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "compiler/schema/value.h"
#include "dsl/source.h"

namespace cdb::evaluate {

__extension__ using Integer = __int128;

/// A number that is exact as long as it is whole: sums, differences, products and powers of whole
/// numbers stay whole, and quotients where they divide. What passes 64 bits goes on as a 64-bit
/// real.
class Number {
 public:
  static Number Whole(Integer value);
  static Number Real(double value) { return Number(false, 0, value); }
  /// A literal of the language; nullopt where it does not fit.
  static std::optional<Number> FromLiteral(std::string_view text);

  bool is_whole() const { return whole_; }
  /// Whole also where a real happens to be: `1e6` is a count.
  std::optional<Integer> AsWhole() const;
  double AsReal() const { return whole_ ? static_cast<double>(integer_) : real_; }
  std::string Text() const;

  Number operator-() const;
  friend Number operator+(const Number& a, const Number& b);
  friend Number operator-(const Number& a, const Number& b);
  friend Number operator*(const Number& a, const Number& b);
  friend Number operator/(const Number& a, const Number& b);
  friend Number Power(const Number& base, const Number& exponent);
  /// Exact where both are whole. NaN compares as different.
  friend std::partial_ordering Compare(const Number& a, const Number& b);

 private:
  Number(bool whole, Integer integer, double real)
      : whole_(whole), integer_(integer), real_(real) {}

  bool whole_;
  Integer integer_;
  double real_;
};

struct Term;

struct DrawnTerm {
  schema::DistributionKind kind = schema::DistributionKind::kUniform;
  std::vector<Term> arguments;
  std::vector<double> weights;
};

struct Term {
  std::variant<Number, schema::Word, schema::Text, Eigen::Vector3d, schema::Ratio, DrawnTerm,
               schema::Call>
      what;
  /// Of a text: where it is written, for a file's name counts from there.
  dsl::Span written = {};

  const Number* number() const { return std::get_if<Number>(&what); }
  const schema::Word* word() const { return std::get_if<schema::Word>(&what); }
  const Eigen::Vector3d* vector() const { return std::get_if<Eigen::Vector3d>(&what); }
  const schema::Text* text() const { return std::get_if<schema::Text>(&what); }
  const DrawnTerm* drawn() const { return std::get_if<DrawnTerm>(&what); }
  const schema::Call* call() const { return std::get_if<schema::Call>(&what); }
};

/// As `.cdb` writes it; a text without its quotes, a model without its hash.
std::string ToText(const Term& term);
/// `a number`, `a vector`: for messages.
std::string KindName(const Term& term);

}  // namespace cdb::evaluate
