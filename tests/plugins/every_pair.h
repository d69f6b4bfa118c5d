// A brute-force broad phase, for detectors that misbehave in other ways.
#pragma once

#include <vector>

#include "library/detectors/detector.h"

namespace cdb {

/// Local to each library that includes it, because several libraries are loaded side by side.
namespace {

class EveryPair : public Detector {
 public:
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    for (Id a = 0; a < scene.size; ++a)
      for (Id b = a + 1; b < scene.size; ++b)
        if (scene.MayCollide(a, b) && Overlap(scene.boxes[a], scene.boxes[b]))
          pairs.push_back({a, b});
  }
};

}  // namespace
}  // namespace cdb
