#include "compiler/bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "compiler/calls.h"

namespace cdb::compiler {
namespace {

using Eigen::Vector3d;

constexpr double kDeviations = 3;
constexpr double kLeastPart = 1e-3;

bool IsNumber(const Value& value) {
  return std::holds_alternative<double>(value) || std::holds_alternative<std::uint64_t>(value);
}

double NumberOf(const Value& value) {
  const auto* count = std::get_if<std::uint64_t>(&value);
  return count != nullptr ? static_cast<double>(*count) : std::get<double>(value);
}

/// The ends of what uniform, log_uniform or normal draws.
std::pair<Vector3d, Vector3d> EndsOf(const Distribution& distribution) {
  const auto part = [&](std::size_t index) -> Vector3d {
    const Value& value = distribution.arguments[index];
    if (IsNumber(value)) return Vector3d::Constant(NumberOf(value));
    return std::get<Vector3d>(value);
  };
  if (distribution.kind != DistributionKind::kNormal) return {part(0), part(1)};
  return {part(0) - kDeviations * part(1), part(0) + kDeviations * part(1)};
}

}  // namespace

Bounds PositiveBounds(const Value& value) {
  if (IsNumber(value)) return {NumberOf(value), NumberOf(value)};
  const auto* distribution = std::get_if<Distribution>(&value);
  if (distribution == nullptr) return {};
  if (distribution->kind == DistributionKind::kAny) {
    Bounds all{std::numeric_limits<double>::infinity(), 0};
    for (const Value& choice : distribution->arguments) {
      if (!IsNumber(choice)) continue;
      all.least = std::min(all.least, NumberOf(choice));
      all.most = std::max(all.most, NumberOf(choice));
    }
    return all.most > 0 ? all : Bounds{};
  }
  const auto [low, high] = EndsOf(*distribution);
  return {std::max(low.x(), kLeastPart * high.x()), high.x()};
}

Vector3d LargestComponents(const Value& value) {
  if (const auto* vector = std::get_if<Vector3d>(&value)) return vector->cwiseAbs();
  if (const Call* schedule = AsCall(value)) {
    if (schedule->name == "every") return LargestComponents(ArgumentOf(*schedule, "value"));
    // It turns, so that any component can get as large as the whole.
    return Vector3d::Constant(LargestComponents(ArgumentOf(*schedule, "vector")).norm());
  }
  const auto* distribution = std::get_if<Distribution>(&value);
  if (distribution == nullptr) return Vector3d::Zero();
  if (distribution->kind == DistributionKind::kAny) {
    Vector3d largest = Vector3d::Zero();
    for (const Value& choice : distribution->arguments)
      largest = largest.cwiseMax(LargestComponents(choice));
    return largest;
  }
  const auto [low, high] = EndsOf(*distribution);
  return low.cwiseAbs().cwiseMax(high.cwiseAbs());
}

bool IsDrawnOrScheduled(const Value& value) {
  return std::holds_alternative<Distribution>(value) || AsCall(value) != nullptr;
}

}  // namespace cdb::compiler
