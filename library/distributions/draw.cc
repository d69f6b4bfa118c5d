#include "library/distributions/draw.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"

namespace cdb::distributions {
namespace {

using schema::Distribution;
using schema::DistributionKind;
using schema::Value;

std::string FullName(std::string_view group, std::string_view parameter) {
  return group.empty() ? std::string(parameter) : fmt::format("{}.{}", group, parameter);
}

/// True for `orientation random`: a word that stands for a distribution.
bool IsRandomWord(const Value& value) {
  const auto* word = std::get_if<schema::Word>(&value);
  return word != nullptr && word->text == "random";
}

/// The value that a word draws from: for `every`, `same` and `density` their value, for `rotating`
/// the vector that it rotates; a table of values over time draws nothing.
const Value& DrawnBy(const Value& value) {
  static const Value kNothing = Eigen::Vector3d(Eigen::Vector3d::Zero());
  const schema::Call* call = schema::AsCall(value);
  if (call != nullptr && call->name == schema::kTableCall) return kNothing;
  if (call != nullptr && (call->name == "every" || call->name == "same" || call->name == "density"))
    return schema::ArgumentOf(*call, "value");
  if (call != nullptr && call->name == "rotating") return schema::ArgumentOf(*call, "vector");
  return value;
}

/// A number, or a component of a vector or a ratio.
double Component(const Value& value, int component) {
  if (const schema::Number* number = schema::AsNumber(value)) return number->AsReal();
  const auto* vector = std::get_if<Eigen::Vector3d>(&value);
  CDB_CHECK(vector != nullptr);
  return (*vector)[component];
}

const Value& Weighed(const Distribution& distribution, Stream& stream) {
  const auto& weights = distribution.weights;
  CDB_CHECK(!weights.empty() && weights.size() == distribution.arguments.size());
  const double at = stream.Uniform() * std::accumulate(weights.begin(), weights.end(), 0.0);
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    sum += weights[i];
    if (at < sum) return distribution.arguments[i];
  }
  return distribution.arguments.back();
}

/// A value of a table; all are equally likely if it has no weights.
const Value& OfTable(const Distribution& table, Stream& stream) {
  if (!table.weights.empty()) return Weighed(table, stream);
  CDB_CHECK(!table.arguments.empty());
  const auto count = static_cast<double>(table.arguments.size());
  const auto index = static_cast<std::size_t>(stream.Uniform() * count);
  return table.arguments[std::min(index, table.arguments.size() - 1)];
}

double FromDistribution(const Distribution& distribution, int component, Stream& stream) {
  const auto argument = [&](std::size_t i) {
    return Component(distribution.arguments.at(i), component);
  };
  switch (distribution.kind) {
    case DistributionKind::kUniform:
      return stream.Uniform(argument(0), argument(1));
    case DistributionKind::kNormal:
      return argument(0) + argument(1) * stream.Normal();
    case DistributionKind::kLogUniform:
      return stream.LogUniform(argument(0), argument(1));
    case DistributionKind::kLognormal:
      return stream.Lognormal(argument(0), argument(1));
    case DistributionKind::kExponential:
      return stream.Exponential(argument(0));
    case DistributionKind::kGamma:
      return stream.Gamma(argument(0), argument(1));
    case DistributionKind::kWeibull:
      return stream.Weibull(argument(0), argument(1));
    case DistributionKind::kEmpirical:
      return Component(OfTable(distribution, stream), component);
    case DistributionKind::kAny:
      break;
  }
  const Value& chosen = Weighed(distribution, stream);
  const Distribution* inner = AsDistribution(chosen);
  return inner != nullptr ? FromDistribution(*inner, component, stream)
                          : Component(chosen, component);
}

}  // namespace

Stream NamedStream(const plan::Scene& scene, std::string_view group, std::string_view parameter) {
  const std::string name = FullName(group, parameter);
  const auto found = scene.seeds.find(name);
  if (found == scene.seeds.end())
    throw library::SceneError(
        fmt::format("the plan has no seed for the stream `{}`; plan again", name));
  return Stream(found->second);
}

Draw::Draw(const plan::Scene& scene, const plan::Settings& settings, std::string_view owner,
           const schema::Parameter& parameter)
    : parameter_(&parameter),
      value_(&DrawnBy(settings.ValueOf(parameter))),
      distribution_(AsDistribution(*value_)),
      name_(FullName(owner, parameter.OwnName())),
      stream_(distribution_ == nullptr && !IsRandomWord(*value_)
                  ? Stream(0)
                  : NamedStream(scene, owner, parameter.OwnName())) {}

const Value& Draw::Choose() {
  const Value* value = value_;
  while (const Distribution* distribution = AsDistribution(*value)) {
    if (distribution->kind != DistributionKind::kAny) break;
    value = &Weighed(*distribution, stream_);
  }
  return *value;
}

double Draw::RealFrom(const Value& value, int component) {
  const Distribution* distribution = AsDistribution(value);
  return distribution != nullptr ? FromDistribution(*distribution, component, stream_)
                                 : Component(value, component);
}

bool Draw::Accepts(const Value& value, double real) const {
  const Distribution* drawn = AsDistribution(value);
  const bool is_within = drawn == nullptr || !drawn->limits ||
                         (real >= drawn->limits->least && real <= drawn->limits->most);
  return is_within && parameter_->domain.Contains(real);
}

double Draw::RealInDomain(const Value& value, int component) {
  for (int tries = 0; tries < kMaxRedraws; ++tries) {
    const double real = RealFrom(value, component);
    if (Accepts(value, real)) return real;
  }
  NeverInDomain();
}

void Draw::NeverInDomain() const {
  throw library::SceneError(
      fmt::format("`{} {}` drew {} values in a row that are not {}; change it", name_,
                  schema::LabelOf(*value_), kMaxRedraws, parameter_->domain.Text()));
}

double Draw::Real() { return RealInDomain(*value_, 0); }

bool Draw::On() {
  const auto* on = std::get_if<bool>(&Choose());
  CDB_CHECK(on != nullptr);
  return *on;
}

const Value& Draw::Choice() {
  const Value& value = Choose();
  CDB_CHECK(std::holds_alternative<schema::Word>(value) || schema::AsCall(value) != nullptr);
  return value;
}

std::optional<double> Draw::RealOrWord(std::string_view* word) {
  for (int tries = 0; tries < kMaxRedraws; ++tries) {
    const Value& value = Choose();
    if (const auto* chosen = std::get_if<schema::Word>(&value)) {
      *word = chosen->text;
      return std::nullopt;
    }
    const double real = RealFrom(value, 0);
    if (Accepts(value, real)) return real;
  }
  NeverInDomain();
}

std::optional<Eigen::Vector3d> Draw::VectorOrWord(std::string_view* word) {
  // A choice is a single draw; other values are drawn component by component.
  const Value& value = Choose();
  if (const auto* chosen = std::get_if<schema::Word>(&value)) {
    *word = chosen->text;
    return std::nullopt;
  }
  const double x = RealInDomain(value, 0);
  const double y = RealInDomain(value, 1);
  return Eigen::Vector3d(x, y, RealInDomain(value, 2));
}

Eigen::Vector3d Draw::Vector() {
  std::string_view word;
  const auto vector = VectorOrWord(&word);
  CDB_CHECK(vector.has_value());
  return *vector;
}

}  // namespace cdb::distributions
