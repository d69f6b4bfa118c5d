// Values: of expressions, and of parameters in the compiler and in the plan.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "compiler/schema/number.h"
#include "dsl/text/source.h"

namespace cdb::schema {

class Value;

/// A word of the language that is not a number: `sphere`, `fixed`, `none`.
struct Word {
  std::string text;
  bool operator==(const Word&) const = default;
};

/// A text in quotes: the name of a file.
struct Text {
  std::string text;
  /// Its location in a scenario, whose folder is the base of a relative name; empty in a plan.
  text::Span written = {};
  bool operator==(const Text& other) const { return text == other.text; }
};

/// A word with arguments: `ring(radius: 20)`, `mesh("rock.obj")`, `every(60, uniform(a, b))`.
/// Complete: a value for each argument of its row in parametrised_words.h, in that order.
struct Call {
  std::string name;
  std::vector<Value> arguments;
  bool operator==(const Call&) const;
};

/// `1 : y : z`.
struct Ratio {
  Eigen::Vector3d parts;
  bool operator==(const Ratio& other) const { return parts == other.parts; }
};

/// The kinds of distribution; `library/distributions` implements their transforms.
enum class DistributionKind {
  kUniform,
  kNormal,
  kLogUniform,
  kAny,
  kLognormal,
  kExponential,
  kGamma,
  kWeibull,
  kEmpirical,
};

/// `in 2 .. 8`: draws outside are repeated, separately for each component of a vector.
struct Limits {
  double least = 0, most = 0;
  bool operator==(const Limits&) const = default;
};

/// A value drawn anew for each object.
/// uniform, log_uniform: arguments are {minimum, maximum}; normal: {mean, standard deviation}; each
/// a real or a vector. any: arguments are the choices (words, calls, reals, booleans), weights
/// their weights, > 0, one for each. lognormal: {mean, standard deviation} of the natural
/// logarithm; exponential: {mean}; gamma, weibull: {shape, scale}; all reals. empirical: arguments
/// are the values of a table, weights as for any, or empty if all are equal.
struct Distribution {
  DistributionKind kind = DistributionKind::kUniform;
  std::vector<Value> arguments;
  std::vector<double> weights;
  std::optional<Limits> limits = {};
  std::string file = {};  ///< for an empirical one: the table it was read from
  bool operator==(const Distribution&) const;
};

/// An expression of values drawn for an object, evaluated for each object: `2 * size ^ 3`
/// (compiler/schema/formula.h). Numbers in it are reals.
struct Formula {
  std::string op;       ///< + - * / ^ or a function; - of one argument negates; empty: a setting
  std::string setting;  ///< the name of a setting of the same group, if `op` is empty
  std::vector<Value> arguments;  ///< numbers and formulae
  /// In a scenario, the location of the setting's name, and its group; empty in a plan.
  text::Span written = {};
  std::string group = {};
  bool operator==(const Formula&) const;
};

/// A list of words (`record timing, counts`).
using WordList = std::vector<std::string>;

/// The value of an expression or, converted for a parameter (compiler/evaluate/convert.h), the
/// setting of a run. Only expressions hold negative integers; only settings hold booleans and
/// lists.
class Value : public std::variant<bool, Number, Word, Eigen::Vector3d, Ratio, WordList,
                                  Distribution, Text, Call, Formula> {
 public:
  using variant::variant;
  bool operator==(const Value&) const = default;
};

/// True if `value` is `word`, or may draw it.
bool MayBe(const Value& value, std::string_view word);

/// Equal, and zeros have the same sign, which == ignores but texts show.
bool IsIdentical(const Value& a, const Value& b);

/// Null if the value is of another kind.
inline const Number* AsNumber(const Value& value) { return std::get_if<Number>(&value); }
inline const Word* AsWord(const Value& value) { return std::get_if<Word>(&value); }
inline const Eigen::Vector3d* AsVector(const Value& value) {
  return std::get_if<Eigen::Vector3d>(&value);
}
inline const Ratio* AsRatio(const Value& value) { return std::get_if<Ratio>(&value); }
inline const Distribution* AsDistribution(const Value& value) {
  return std::get_if<Distribution>(&value);
}
inline const Text* AsText(const Value& value) { return std::get_if<Text>(&value); }
inline const Call* AsCall(const Value& value) { return std::get_if<Call>(&value); }
inline const Formula* AsFormula(const Value& value) { return std::get_if<Formula>(&value); }

/// True for the number 0 or the vector 0.
inline bool IsZero(const Value& value) {
  const Number* number = AsNumber(value);
  const Eigen::Vector3d* vector = AsVector(value);
  return number != nullptr ? number->AsReal() == 0 : vector != nullptr && vector->isZero(0);
}

/// A row of the table of distributions.
struct DistributionInfo {
  std::string_view name;
  DistributionKind kind;
  std::size_t arguments;   ///< the number of arguments, all of them numbers; 0: a list
  std::string_view usage;  ///< `gamma(shape, scale)`
};

const DistributionInfo& InfoOf(DistributionKind kind);
/// `uniform`, `normal`, `log_uniform`, `any`, …; and the reverse.
std::string_view DistributionName(DistributionKind kind);
std::optional<DistributionKind> FindDistribution(std::string_view name);
std::vector<std::string_view> DistributionNames();

/// A value as written in `.cdb`: `normal(275, 75)`, `1 : 1 : 5`, `any(sphere 3, cone)`.
std::string ToText(const Value& value);
/// The same as a label: texts without quotes, files without hashes.
std::string LabelOf(const Value& value);

}  // namespace cdb::schema
