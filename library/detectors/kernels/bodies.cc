#include "library/detectors/kernels/bodies.h"

#include <algorithm>

namespace cdb::kernels {
namespace {

constexpr std::size_t kMaxWalls = 64;

bool AreSame(const Filter& a, const Filter& b) {
  return a.group == b.group && a.mask == b.mask && a.is_fixed == b.is_fixed;
}

bool AreSame(const Box& a, const Box& b) {
  return a.lower.x == b.lower.x && a.lower.y == b.lower.y && a.lower.z == b.lower.z &&
         a.upper.x == b.upper.x && a.upper.y == b.upper.y && a.upper.z == b.upper.z;
}

}  // namespace

void Bodies::Learn(const Scene& scene) {
  size_ = movers_ = scene.size;
  while (movers_ > 0 && scene.filters[movers_ - 1].is_fixed) --movers_;
  if (size_ - movers_ > kMaxWalls) movers_ = size_;
  const auto movers = scene.filters.first(movers_);
  movers_collide_ =
      std::ranges::all_of(movers, [&](const Filter& f) { return AreSame(f, movers[0]); }) &&
      (movers_ == 0 || scene.MayCollide(0, 0));
}

void Bodies::MeetWalls(const Scene& scene, const Kernels& kernels, PairBuffer& pairs) const {
  const std::size_t before = pairs.size();
  const auto first = static_cast<Id>(movers_);
  for (Id wall = first; wall < scene.size;) {
    // A scene's planes all have the box that is everywhere.
    Id end = wall + 1;
    while (end < scene.size && AreSame(scene.boxes[end], scene.boxes[wall]) &&
           AreSame(scene.filters[end], scene.filters[wall]))
      ++end;
    if (!movers_collide_ || (movers_ > 0 && scene.MayCollide(0, wall)))
      kernels.meet_wall(scene.boxes.data(), movers_, scene.boxes[wall], wall, end - wall,
                        pairs.sink());
    wall = end;
  }
  if (movers_collide_) return;
  const auto rest = std::ranges::remove_if(pairs.pairs().subspan(before), [&](const Pair& pair) {
    return !scene.MayCollide(pair.a, pair.b);
  });
  pairs.Cut(pairs.size() - rest.size());
}

void Bodies::Sieve(const Scene& scene, bool is_exact, PairBuffer& pairs) const {
  if (is_exact && movers_collide_) return;
  const auto rest = std::ranges::remove_if(pairs.pairs(), [&](const Pair& pair) {
    return !(is_exact || Overlap(scene.boxes[pair.a], scene.boxes[pair.b])) ||
           !(movers_collide_ || scene.MayCollide(pair.a, pair.b));
  });
  pairs.Cut(pairs.size() - rest.size());
}

}  // namespace cdb::kernels
