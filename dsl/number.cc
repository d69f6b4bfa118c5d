#include "dsl/number.h"

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "dsl/diagnostic_kinds.h"
#include "dsl/text/characters.h"
#include "dsl/text/concat.h"
#include "dsl/text/units.h"

namespace cdb::dsl {
namespace {

class NumberCheck {
 public:
  NumberCheck(std::string_view lexeme, const text::Span& span, Diagnostics& diagnostics)
      : lexeme_(lexeme), span_(span), diagnostics_(diagnostics) {}

  bool Run() {
    const bool is_hex = lexeme_.starts_with("0x") || lexeme_.starts_with("0X");
    if (!TakeDigits(is_hex)) return false;
    if (is_hex) return CheckHex();
    if (digits_.front() == '.')
      return Refuse(kBadNumber, "a number must begin with a digit",
                    text::Concat({"write 0", lexeme_}));
    if (digits_.back() == '.')
      return Refuse(kBadNumber, "a number cannot end with a point",
                    text::Concat({"write ", lexeme_, "0, or leave the point out"}));
    return CheckDecimal();
  }

 private:
  bool Refuse(const DiagnosticKind& kind, std::string message, std::string help) {
    diagnostics_.Report(kind, span_, std::move(message), std::move(help));
    return false;
  }
  std::string Quoted() const { return text::Concat({"'", lexeme_, "'"}); }
  bool RefuseForm(std::string help) {
    return Refuse(kBadNumber, Quoted() + " is not a number", std::move(help));
  }

  /// Appends digits to `digits_`, without the underscores.
  bool TakeDigits(bool is_hex) {
    const auto is_digit = is_hex ? text::IsHexDigit : text::IsDigit;
    for (std::size_t i = 0; i < lexeme_.size(); ++i) {
      if (lexeme_[i] != '_') {
        digits_ += lexeme_[i];
        continue;
      }
      if (i == 0 || i + 1 == lexeme_.size() || !is_digit(lexeme_[i - 1]) ||
          !is_digit(lexeme_[i + 1]))
        return RefuseForm("'_' is only allowed between two digits: 1_000");
    }
    return true;
  }

  bool CheckHex() {
    const char *begin = digits_.data() + 2, *end = digits_.data() + digits_.size();
    std::uint64_t value = 0;
    const auto [stop, error] = std::from_chars(begin, end, value, 16);
    if (stop != end || stop == begin)
      return RefuseForm("0x must be followed by the digits 0 to 9 and A to F, without a point");
    if (error == std::errc::result_out_of_range)
      return Refuse(kNumberRange, Quoted() + " does not fit into 64 bits",
                    "the largest is 0xFFFFFFFFFFFFFFFF");
    return true;
  }

  bool SkipDigits(std::size_t& at) const {
    const std::size_t from = at;
    while (at < digits_.size() && text::IsDigit(digits_[at])) ++at;
    return at > from;
  }

  /// Skips digits, a point between digits, and an exponent with digits. Nullopt if one of these is
  /// incomplete, otherwise whether the number is an integer.
  std::optional<bool> SkipDecimal(std::size_t& at) const {
    const auto has = [&](std::string_view any) {
      return at < digits_.size() && any.find(digits_[at]) != std::string_view::npos;
    };
    bool is_whole = true;
    SkipDigits(at);
    if (has(".")) {
      is_whole = false;
      ++at;
      if (!SkipDigits(at)) return std::nullopt;
    }
    if (has("eE")) {
      is_whole = false;
      ++at;
      if (has("+-")) ++at;
      if (!SkipDigits(at)) return std::nullopt;
    }
    return is_whole;
  }

  bool CheckDecimal() {
    std::size_t at = 0;
    const std::optional<bool> is_whole = SkipDecimal(at);
    if (!is_whole) return RefuseForm("");
    if (at < digits_.size()) {
      const std::string_view rest = std::string_view(digits_).substr(at);
      const std::string_view unit = text::IsUnitName(rest) ? rest : text::UnitCalled(rest);
      return RefuseForm(unit.empty() ? ""
                                     : text::Concat({"write a space before the unit: ",
                                                     digits_.substr(0, at), " ", unit}));
    }
    return *is_whole ? CheckWholeRange() : CheckRealRange();
  }

  template <typename Number>
  bool Fits() const {
    Number value = 0;
    return std::from_chars(digits_.data(), digits_.data() + digits_.size(), value).ec !=
           std::errc::result_out_of_range;
  }
  bool CheckWholeRange() {
    return Fits<std::uint64_t>() ||
           Refuse(kNumberRange, Quoted() + " does not fit into 64 bits",
                  "if a rounded number is enough, write it with an exponent: 1e20");
  }
  bool CheckRealRange() {
    return Fits<double>() || Refuse(kNumberRange, Quoted() + " does not fit into a 64-bit real",
                                    "reals range from about 1e-308 to 1.8e308");
  }

  std::string_view lexeme_;
  const text::Span& span_;
  Diagnostics& diagnostics_;
  std::string digits_;
};

}  // namespace

bool CheckNumber(std::string_view lexeme, const text::Span& span, Diagnostics& diagnostics) {
  return NumberCheck(lexeme, span, diagnostics).Run();
}

}  // namespace cdb::dsl
