#include "compiler/checks/bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "compiler/schema/parametrised_words.h"

namespace cdb::checks {
namespace {

using Eigen::Vector3d;

constexpr double kDeviations = 3;
constexpr double kLeastPart = 1e-3;

/// The ends of what uniform, log_uniform or normal draws.
std::pair<Vector3d, Vector3d> EndsOf(const schema::Distribution& distribution) {
  const auto part = [&](std::size_t index) -> Vector3d {
    const schema::Value& value = distribution.arguments[index];
    if (const schema::Number* number = schema::AsNumber(value))
      return Vector3d::Constant(number->AsReal());
    return std::get<Vector3d>(value);
  };
  if (distribution.kind != schema::DistributionKind::kNormal) return {part(0), part(1)};
  return {part(0) - kDeviations * part(1), part(0) + kDeviations * part(1)};
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
    // It turns, so that any component can get as large as the whole.
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

bool IsDrawnOrScheduled(const schema::Value& value) {
  return std::holds_alternative<schema::Distribution>(value) || schema::AsCall(value) != nullptr;
}

}  // namespace cdb::checks
