// A broad phase for cdb: bodies sorted along x, and each compared with those that begin before it
// ends. The order of the last cycle is nearly that of this one.
#include <cdb/detector.h>

#include <algorithm>
#include <numeric>

namespace {

class SortedAlongX final : public cdb::Detector {
 public:
  void Prepare(const cdb::Scene& scene) override {
    order_.resize(scene.size);
    std::iota(order_.begin(), order_.end(), cdb::Id{0});
  }

  void FindPairs(const cdb::Scene& scene, std::vector<cdb::Pair>& pairs) override {
    const auto lower = [&](cdb::Id id) { return scene.boxes[id].lower.x; };
    std::ranges::sort(order_, {}, lower);
    for (auto one = order_.begin(); one != order_.end(); ++one)
      for (auto other = one + 1; other != order_.end(); ++other) {
        if (lower(*other) > scene.boxes[*one].upper.x) break;
        if (cdb::Overlap(scene.boxes[*one], scene.boxes[*other]) && scene.MayCollide(*one, *other))
          pairs.push_back({std::min(*one, *other), std::max(*one, *other)});
      }
  }

 private:
  std::vector<cdb::Id> order_;
};

constexpr cdb::DetectorEntry kDetectors[] = {
    {"sorted_along_x", "bodies sorted along x, and a sweep over them", cdb::kBroad, 0,
     [](const cdb::Options&) -> cdb::Detector* { return new SortedAlongX; }},
};

}  // namespace

CDB_DETECTORS(kDetectors)
