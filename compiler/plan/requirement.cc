#include "compiler/plan/requirement.h"

#include <algorithm>
#include <iterator>

#include "compiler/schema/metrics.h"
#include "compiler/schema/series.h"

namespace cdb::plan {
namespace {

constexpr std::string_view kComparisons[] = {"==", "!=", "<", "<=", ">", ">="};
constexpr std::string_view kSeriesStatistics[] = {"mean", "median", "p5",  "p95",
                                                  "p99",  "min",    "max", kFinal};

const schema::RunScalarInfo* FindScalar(std::string_view name) {
  const auto* found = std::ranges::find(schema::kRunScalars, name, &schema::RunScalarInfo::name);
  return found == std::end(schema::kRunScalars) ? nullptr : found;
}

const schema::ErrorInfo* FindError(std::string_view name) {
  const auto found = std::ranges::find(schema::Errors(), name, &schema::ErrorInfo::name);
  return found == schema::Errors().end() ? nullptr : &*found;
}

bool IsStatistic(FigureKind kind, std::string_view word) {
  return std::ranges::find(StatisticsOf(kind), word) != StatisticsOf(kind).end();
}

}  // namespace

std::span<const std::string_view> StatisticsOf(FigureKind kind) {
  if (kind == FigureKind::kTime) return kCycleStatistics;
  if (kind == FigureKind::kSeries) return kSeriesStatistics;
  return {};
}

std::string Figure::Text() const {
  if (kind == FigureKind::kError) return "error(" + name + ")";
  return statistic.empty() ? name : statistic + "(" + name + ")";
}

std::string_view Figure::Unit() const {
  switch (kind) {
    case FigureKind::kVerdict:
      return {};
    case FigureKind::kTime:
      return schema::FindSeries("duration")->unit;
    case FigureKind::kSeries:
      return schema::FindSeries(name)->unit;
    case FigureKind::kError:
      return FindError(name)->unit;
    case FigureKind::kScalar:
      return FindScalar(name)->unit;
  }
  return {};
}

bool Figure::IsMeasured() const {
  return statistic != "worst" &&
         (kind == FigureKind::kTime || (kind == FigureKind::kScalar && Unit() == "ns"));
}

std::optional<Figure> FindFigure(std::string_view text) {
  if (text == "verdict") return Figure{};
  const std::size_t open = text.find('(');
  if (open == std::string_view::npos) {
    if (FindScalar(text) == nullptr) return std::nullopt;
    return Figure{FigureKind::kScalar, std::string(text), {}};
  }
  if (!text.ends_with(')')) return std::nullopt;
  const std::string statistic(text.substr(0, open)),
      name(text.substr(open + 1, text.size() - open - 2));
  if (statistic == "error") {
    if (FindError(name) == nullptr) return std::nullopt;
    return Figure{FigureKind::kError, name, {}};
  }
  const bool is_time = std::ranges::find(schema::kPhases, name) != std::end(schema::kPhases);
  const schema::Series* series = schema::FindSeries(name);
  const FigureKind kind = is_time ? FigureKind::kTime : FigureKind::kSeries;
  const bool is_series = series != nullptr && series->shape == schema::SeriesShape::kScalar;
  if ((!is_time && !is_series) || !IsStatistic(kind, statistic)) return std::nullopt;
  return Figure{kind, name, statistic};
}

std::string_view ComparisonText(Comparison comparison) {
  return kComparisons[static_cast<std::size_t>(comparison)];
}

std::optional<Comparison> FindComparison(std::string_view text) {
  const auto* found = std::ranges::find(kComparisons, text);
  if (found == std::end(kComparisons)) return std::nullopt;
  return static_cast<Comparison>(found - std::begin(kComparisons));
}

Comparison Reversed(Comparison comparison) {
  switch (comparison) {
    case Comparison::kLess:
      return Comparison::kGreater;
    case Comparison::kAtMost:
      return Comparison::kAtLeast;
    case Comparison::kGreater:
      return Comparison::kLess;
    case Comparison::kAtLeast:
      return Comparison::kAtMost;
    case Comparison::kEqual:
    case Comparison::kNotEqual:
      break;
  }
  return comparison;
}

bool Holds(double value, Comparison comparison, double limit) {
  switch (comparison) {
    case Comparison::kEqual:
      return value == limit;
    case Comparison::kNotEqual:
      return value != limit;
    case Comparison::kLess:
      return value < limit;
    case Comparison::kAtMost:
      return value <= limit;
    case Comparison::kGreater:
      return value > limit;
    case Comparison::kAtLeast:
      return value >= limit;
  }
  return false;
}

}  // namespace cdb::plan
