#include "compiler/schema/series.h"

#include <algorithm>

namespace cdb::schema {
namespace {

std::uint64_t ExtentOf(Dimension dimension, const RunExtents& run) {
  switch (dimension) {
    case Dimension::kCycle:
      return run.cycles;
    case Dimension::kBody:
      return run.objects;
    case Dimension::kBoxBody:
      return run.bodies;
    case Dimension::kQueryRow:
      return run.queries;
    case Dimension::kVertex:
      return run.nodes;
    default:
      return InfoOf(dimension).labels.size();
  }
}

}  // namespace

std::span<const Dimension> DimensionsOf(SeriesShape shape) {
  using enum Dimension;
  static constexpr Dimension kOfScalar[] = {kCycle}, kOfPhase[] = {Dimension::kPhase, kCycle},
                             kOfPose[] = {kCycle, kBody, Dimension::kPose},
                             kOfBox[] = {kCycle, kBoxBody, kBound},
                             kOfFilter[] = {kBoxBody, Dimension::kFilter},
                             kOfSample[] = {Dimension::kSample},
                             kOfQuery[] = {Dimension::kQuery, kCycle},
                             kOfAnswer[] = {kCycle, kQueryRow, Dimension::kAnswer},
                             kOfVertex[] = {kCycle, Dimension::kVertex, kCoordinate},
                             kOfCounter[] = {Dimension::kCounter, Dimension::kPhase, kCycle};
  switch (shape) {
    case SeriesShape::kScalar:
      return kOfScalar;
    case SeriesShape::kPhase:
      return kOfPhase;
    case SeriesShape::kPose:
      return kOfPose;
    case SeriesShape::kBox:
      return kOfBox;
    case SeriesShape::kFilter:
      return kOfFilter;
    case SeriesShape::kSample:
      return kOfSample;
    case SeriesShape::kQuery:
      return kOfQuery;
    case SeriesShape::kAnswer:
      return kOfAnswer;
    case SeriesShape::kVertex:
      return kOfVertex;
    case SeriesShape::kCounter:
      return kOfCounter;
  }
  return {};
}

std::optional<std::size_t> Series::CycleDimension() const {
  const auto dimensions = DimensionsOf(shape);
  const auto found = std::ranges::find(dimensions, Dimension::kCycle);
  if (found == dimensions.end()) return std::nullopt;
  return static_cast<std::size_t>(found - dimensions.begin());
}

std::vector<std::uint64_t> Series::Extents(const RunExtents& run) const {
  std::vector<std::uint64_t> extents;
  for (const Dimension dimension : DimensionsOf(shape)) extents.push_back(ExtentOf(dimension, run));
  return extents;
}

std::size_t Series::ValueCount(const RunExtents& run) const {
  std::size_t count = 1;
  for (const std::uint64_t extent : Extents(run)) count *= extent;
  return count;
}

const Series* FindSeries(std::string_view name) {
  const auto row = std::ranges::find(kSeries, name, &Series::name);
  return row == kSeries.end() ? nullptr : &*row;
}

}  // namespace cdb::schema
