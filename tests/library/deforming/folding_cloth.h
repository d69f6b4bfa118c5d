// A square cloth that folds about a line, as a sequence of meshes.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "library/deforming/mesh_sequence.h"

namespace cdb::tests {

/// A cloth of `side` times `side` vertices in the plane z = 0, at distance 1. The part of x > 0
/// turns upwards about the line x = 0 by equal angles, until it lies on the other part in the last
/// frame. `side` is odd, so that a row of vertices is on the line.
inline deforming::MeshSequence FoldingCloth(std::uint32_t side, std::size_t frames) {
  deforming::MeshSequence cloth;
  for (std::uint32_t j = 0; j + 1 < side; ++j)
    for (std::uint32_t i = 0; i + 1 < side; ++i) {
      const std::uint32_t at = j * side + i;
      cloth.triangles.push_back({at, at + 1, at + side});
      cloth.triangles.push_back({at + 1, at + side + 1, at + side});
    }
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const double angle = frames == 1 ? 0
                                     : std::numbers::pi * static_cast<double>(frame) /
                                           static_cast<double>(frames - 1);
    auto& vertices = cloth.frames.emplace_back();
    for (std::uint32_t j = 0; j < side; ++j)
      for (std::uint32_t i = 0; i < side; ++i) {
        const double x = static_cast<double>(i) - (side - 1) / 2.0;
        const double y = static_cast<double>(j);
        // The last frame is exact.
        if (x <= 0)
          vertices.emplace_back(x, y, 0);
        else if (frames > 1 && frame + 1 == frames)
          vertices.emplace_back(-x, y, 0);
        else
          vertices.emplace_back(x * std::cos(angle), y, x * std::sin(angle));
      }
  }
  return cloth;
}

}  // namespace cdb::tests
