#include "compiler/evaluate/term.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "compiler/schema/parametrised_words.h"

namespace cdb::evaluate {
namespace {

constexpr Integer kMost = Integer{1} << 64;

std::string VectorText(const Eigen::Vector3d& v, std::string_view pattern) {
  return fmt::format(fmt::runtime(pattern), schema::FormatReal(v.x()), schema::FormatReal(v.y()),
                     schema::FormatReal(v.z()));
}

}  // namespace

Number Number::Whole(Integer value) {
  if (value > kMost || value < -kMost) return Real(static_cast<double>(value));
  return Number(true, value, 0);
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
  return Real(real);
}

std::optional<Integer> Number::AsWhole() const {
  if (whole_) return integer_;
  // Past 2^53 a real that looks whole has lost its last digits.
  if (std::floor(real_) != real_ || std::fabs(real_) > 9007199254740992.0) return std::nullopt;
  return static_cast<Integer>(real_);
}

std::string Number::Text() const {
  return whole_ ? fmt::format("{}", integer_) : schema::FormatReal(real_);
}

Number Number::operator-() const { return whole_ ? Whole(-integer_) : Real(-real_); }

Number operator+(const Number& a, const Number& b) {
  if (a.whole_ && b.whole_) return Number::Whole(a.integer_ + b.integer_);
  return Number::Real(a.AsReal() + b.AsReal());
}

Number operator-(const Number& a, const Number& b) { return a + -b; }

Number operator*(const Number& a, const Number& b) {
  Integer product = 0;
  if (a.whole_ && b.whole_ && !__builtin_mul_overflow(a.integer_, b.integer_, &product))
    return Number::Whole(product);
  return Number::Real(a.AsReal() * b.AsReal());
}

Number operator/(const Number& a, const Number& b) {
  if (a.whole_ && b.whole_ && b.integer_ != 0 && a.integer_ % b.integer_ == 0)
    return Number::Whole(a.integer_ / b.integer_);
  return Number::Real(a.AsReal() / b.AsReal());
}

Number Power(const Number& base, const Number& exponent) {
  if (base.whole_ && exponent.whole_ && exponent.integer_ >= 0 && exponent.integer_ <= 64) {
    Number power = Number::Whole(1);
    for (Integer i = 0; i < exponent.integer_; ++i) power = power * base;
    return power;
  }
  return Number::Real(std::pow(base.AsReal(), exponent.AsReal()));
}

std::partial_ordering Compare(const Number& a, const Number& b) {
  if (a.whole_ && b.whole_)
    return a.integer_ < b.integer_   ? std::partial_ordering::less
           : a.integer_ > b.integer_ ? std::partial_ordering::greater
                                     : std::partial_ordering::equivalent;
  return a.AsReal() <=> b.AsReal();
}

std::string ToText(const Term& term) {
  struct TextOf {
    std::string operator()(const Number& number) const { return number.Text(); }
    std::string operator()(const schema::Word& word) const { return word.text; }
    std::string operator()(const schema::Text& text) const { return text.text; }
    std::string operator()(const Eigen::Vector3d& v) const { return VectorText(v, "({}, {}, {})"); }
    std::string operator()(const schema::Ratio& ratio) const {
      return VectorText(ratio.parts, "{} : {} : {}");
    }
    std::string operator()(schema::Call call) const {
      // The user has written no hash, and an axis needs none to tell its values apart.
      const schema::ParametrisedWord& info = *schema::FindParametrisedWord(call.name);
      if (schema::NamesFile(info)) call.arguments[1] = schema::DefaultOf(info.arguments[1]);
      return ToText(schema::Value(std::move(call)));
    }
    std::string operator()(const DrawnTerm& drawn) const {
      std::string text = std::string(schema::DistributionName(drawn.kind)) + "(";
      for (std::size_t i = 0; i < drawn.arguments.size(); ++i) {
        if (i > 0) text += ", ";
        text += ToText(drawn.arguments[i]);
        if (!drawn.weights.empty() && drawn.weights[i] != 1)
          text += " " + schema::FormatReal(drawn.weights[i]);
      }
      return text + ")";
    }
  };
  return std::visit(TextOf{}, term.what);
}

std::string KindName(const Term& term) {
  struct NameOf {
    std::string operator()(const Number& number) const {
      return fmt::format("the number {}", number.Text());
    }
    std::string operator()(const schema::Word& word) const {
      return fmt::format("'{}'", word.text);
    }
    std::string operator()(const schema::Text&) const { return "a text"; }
    std::string operator()(const Eigen::Vector3d&) const { return "a vector"; }
    std::string operator()(const schema::Ratio&) const { return "a ratio"; }
    std::string operator()(const schema::Call& call) const {
      return fmt::format("{}( )", call.name);
    }
    std::string operator()(const DrawnTerm& drawn) const {
      return fmt::format("the distribution {}( )", schema::DistributionName(drawn.kind));
    }
  };
  return std::visit(NameOf{}, term.what);
}

}  // namespace cdb::evaluate
