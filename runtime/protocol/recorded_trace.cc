#include "runtime/protocol/recorded_trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "runtime/protocol/series.h"

namespace cdb::protocol {
namespace {

/// Bodies without a filter were never in the world: they are omitted walls.
std::vector<std::size_t> BodiesOf(const Recording& recording) {
  const auto filters = recording.Reals("box_filters");
  std::vector<std::size_t> bodies;
  for (std::size_t i = 0; i < filters.size() / kFilterSize; ++i)
    if (!std::isnan(filters[i * kFilterSize])) bodies.push_back(i);
  return bodies;
}

}  // namespace

TraceMemory TraceOf(const plan::Scene& scene, const Recording& recording) {
  const std::vector<std::size_t> bodies = BodiesOf(recording);
  if (bodies.empty())
    throw std::runtime_error("the scene has no bodies, so there is nothing to trace");
  const std::uint64_t cycles = scene.world.Count("cycles");
  const bool is_double = scene.world.WordOr("precision") == "double";
  const auto filters = recording.Reals("box_filters"), boxes = recording.Reals("boxes");
  const std::size_t all = filters.size() / kFilterSize;
  TraceMemory trace = TraceMemory::Create({bodies.size(), cycles, is_double});
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double* filter = &filters[bodies[i] * kFilterSize];
    trace.filters()[i] = {static_cast<std::uint32_t>(filter[0]),
                          static_cast<std::uint32_t>(filter[1]),
                          static_cast<std::uint32_t>(filter[2])};
  }
  std::vector<double> sides(trace.shape().PerCycle());
  for (std::uint64_t cycle = 0; cycle < cycles; ++cycle) {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const auto box = boxes.subspan((cycle * all + bodies[i]) * kBoxSize, kBoxSize);
      if (std::ranges::any_of(box, [](double side) { return std::isnan(side); }))
        throw std::runtime_error(
            fmt::format("the box of body {} is not finite in cycle {}: the scene exploded; run it "
                        "by `cdb run` to see how",
                        bodies[i], cycle));
      std::ranges::copy(box, &sides[i * kBoxSize]);
    }
    trace.SetBoxes(cycle, sides);
  }
  return trace;
}

}  // namespace cdb::protocol
