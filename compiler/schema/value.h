// What a parameter holds once every sweep has been resolved: a constant or a distribution.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

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
  bool operator==(const Text&) const = default;
};

/// A word that takes arguments: `ring(radius: 20)`, `mesh("rock.obj")`, `every(60, uniform(a, b))`.
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

/// The kinds of distribution; their transforms are in `library/distributions`.
enum class DistributionKind { kUniform, kNormal, kLogUniform, kAny };

/// A value drawn anew for each object.
/// uniform, log_uniform: arguments are {minimum, maximum}; normal: {mean, standard deviation}; each
/// a real or a vector. any: arguments are the choices (words, calls, reals, booleans), weights
/// their weights, > 0, as many.
struct Distribution {
  DistributionKind kind = DistributionKind::kUniform;
  std::vector<Value> arguments;
  std::vector<double> weights;
  bool operator==(const Distribution&) const;
};

/// A list of words (`record timing, counts`).
using WordList = std::vector<std::string>;

/// The value of one parameter of one run. Integers are unsigned: no integer parameter takes a
/// negative one.
class Value : public std::variant<bool, std::uint64_t, double, Word, Eigen::Vector3d, Ratio,
                                  WordList, Distribution, Text, Call> {
 public:
  using variant::variant;
  bool operator==(const Value&) const = default;
};

/// `uniform`, `normal`, `log_uniform`, `any`; and back.
std::string_view DistributionName(DistributionKind kind);
std::optional<DistributionKind> FindDistribution(std::string_view name);

/// The shortest text that reads back to the same double: `0.1`, `1e-09`, `250`.
std::string FormatReal(double value);

/// A value as `.cdb` writes it: `normal(275, 75)`, `1 : 1 : 5`, `any(sphere 3, cone)`.
std::string ToText(const Value& value);

}  // namespace cdb::schema
