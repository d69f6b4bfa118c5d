#include "compiler/lints/bounds.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

#include "compiler/schema/cumulative.h"
#include "compiler/schema/formula.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::lints {
namespace {

using Eigen::Vector3d;

constexpr double kLeastPart = 1e-3;
/// The maximum number of settings by which a formula is searched.
constexpr std::size_t kMostNamed = 6;

/// The usual minimum and maximum of a distribution of numbers or vectors.
std::pair<Vector3d, Vector3d> EndsOf(const schema::Distribution& distribution) {
  const auto is_vector = [](const schema::Value& value) {
    return schema::AsVector(value) != nullptr;
  };
  if (std::ranges::none_of(distribution.arguments, is_vector)) {
    const schema::Limits range = schema::UsualRange(distribution);
    return {Vector3d::Constant(range.least), Vector3d::Constant(range.most)};
  }
  std::pair<Vector3d, Vector3d> ends;
  for (int i = 0; i < 3; ++i) {
    schema::Distribution component = distribution;
    for (schema::Value& argument : component.arguments) argument = (*schema::AsVector(argument))[i];
    const schema::Limits range = schema::UsualRange(component);
    ends.first[i] = range.least;
    ends.second[i] = range.most;
  }
  return ends;
}

}  // namespace

Bounds PositiveBounds(const schema::Value& value) {
  if (const schema::Number* number = schema::AsNumber(value))
    return {number->AsReal(), number->AsReal()};
  if (const schema::Call* call = schema::AsCall(value); call != nullptr)
    return PositiveBounds(schema::ArgumentOf(*call, "value"));
  const auto* distribution = std::get_if<schema::Distribution>(&value);
  if (distribution == nullptr) return {};
  if (distribution->kind == schema::DistributionKind::kAny) {
    Bounds all{std::numeric_limits<double>::infinity(), 0};
    for (const schema::Value& choice : distribution->arguments) {
      const schema::Number* number = schema::AsNumber(choice);
      if (number == nullptr) continue;
      all.least = std::min(all.least, number->AsReal());
      all.most = std::max(all.most, number->AsReal());
    }
    return all.most > 0 ? all : Bounds{};
  }
  const auto [low, high] = EndsOf(*distribution);
  return {std::max(low.x(), kLeastPart * high.x()), high.x()};
}

Vector3d LargestComponents(const schema::Value& value) {
  if (const auto* vector = std::get_if<Vector3d>(&value)) return vector->cwiseAbs();
  if (const schema::Call* schedule = schema::AsCall(value)) {
    if (schedule->name == "every") return LargestComponents(schema::ArgumentOf(*schedule, "value"));
    // It turns, so that any component can reach the full length.
    return Vector3d::Constant(LargestComponents(schema::ArgumentOf(*schedule, "vector")).norm());
  }
  const auto* distribution = std::get_if<schema::Distribution>(&value);
  if (distribution == nullptr) return Vector3d::Zero();
  if (distribution->kind == schema::DistributionKind::kAny) {
    Vector3d largest = Vector3d::Zero();
    for (const schema::Value& choice : distribution->arguments)
      largest = largest.cwiseMax(LargestComponents(choice));
    return largest;
  }
  const auto [low, high] = EndsOf(*distribution);
  return low.cwiseAbs().cwiseMax(high.cwiseAbs());
}

Bounds PositiveBounds(const schema::Value& value,
                      const std::function<Bounds(std::string_view)>& bounds_of) {
  if (const schema::Call* call = schema::AsCall(value); call != nullptr)
    return PositiveBounds(schema::ArgumentOf(*call, "value"), bounds_of);
  const schema::Formula* formula = schema::AsFormula(value);
  if (formula == nullptr) return PositiveBounds(value);
  std::map<std::string_view, Bounds> named;
  for (const schema::Formula* name : schema::SettingsIn(value))
    if (!named.contains(name->setting)) named[name->setting] = bounds_of(name->setting);
  if (named.size() > kMostNamed) return {};
  Bounds all{std::numeric_limits<double>::infinity(), 0};
  for (unsigned corner = 0; corner < 1u << named.size(); ++corner) {
    const double number = schema::Evaluate(*formula, [&](std::string_view name) {
      const auto at = named.find(name);
      const bool is_most = (corner >> std::distance(named.begin(), at) & 1) != 0;
      return is_most ? at->second.most : at->second.least;
    });
    if (!std::isfinite(number)) return {};
    all.least = std::min(all.least, number);
    all.most = std::max(all.most, number);
  }
  return all.most > 0 ? Bounds{std::max(all.least, kLeastPart * all.most), all.most} : Bounds{};
}

bool IsDrawnOrScheduled(const schema::Value& value) {
  return std::holds_alternative<schema::Distribution>(value) || schema::AsCall(value) != nullptr;
}

}  // namespace cdb::lints
