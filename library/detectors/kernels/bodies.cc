#include "library/detectors/kernels/bodies.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

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

/// Moves the side of the room that faces `wall`, as seen from `middle`, to the face of the wall;
/// false if the wall contains `middle`.
bool Bound(const Box& wall, const Vec3& middle, Box& room) {
  double farthest = 0;
  double Vec3::*side = nullptr;
  bool is_lower = false;
  for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    const double below = middle.*axis - wall.upper.*axis, above = wall.lower.*axis - middle.*axis;
    if (std::max(below, above) <= farthest) continue;
    farthest = std::max(below, above);
    side = axis;
    is_lower = below > above;
  }
  if (side == nullptr) return false;
  double& end = is_lower ? room.lower.*side : room.upper.*side;
  end = is_lower ? std::max(end, wall.upper.*side) : std::min(end, wall.lower.*side);
  return true;
}

/// The mean centre of the finite boxes in a sample.
Vec3 MiddleOf(std::span<const Box> boxes) {
  constexpr std::size_t kSample = 64;
  Vec3 sum = {0, 0, 0};
  double count = 0;
  for (std::size_t k = 0; k < std::min(boxes.size(), kSample); ++k) {
    const Box& box = boxes[SampleIndex(k, boxes.size())];
    const Vec3 at = {box.lower.x / 2 + box.upper.x / 2, box.lower.y / 2 + box.upper.y / 2,
                     box.lower.z / 2 + box.upper.z / 2};
    if (!std::isfinite(at.x + at.y + at.z)) continue;
    sum = {sum.x + at.x, sum.y + at.y, sum.z + at.z};
    ++count;
  }
  return count > 0 ? Vec3{sum.x / count, sum.y / count, sum.z / count} : sum;
}

std::size_t SecondClassOf(const Scene& scene, std::size_t movers) {
  const auto filters = scene.filters.first(movers);
  const auto other =
      std::ranges::find_if(filters.begin(), filters.end(),
                           [&](const Filter& filter) { return !AreSame(filter, filters[0]); });
  if (other == filters.end() || !std::all_of(other, filters.end(), [&](const Filter& filter) {
        return AreSame(filter, *other);
      }))
    return 0;
  const auto second = static_cast<Id>(other - filters.begin());
  const bool are_classes =
      scene.MayCollide(0, second) && !scene.MayCollide(0, 0) && !scene.MayCollide(second, second);
  return are_classes ? second : 0;
}

}  // namespace

void Bodies::Learn(const Scene& scene) {
  size_ = movers_ = scene.size;
  const auto stays = [](const Filter& filter) { return filter.is_fixed && !filter.is_kinematic; };
  while (movers_ > 0 && stays(scene.filters[movers_ - 1])) --movers_;
  if (size_ - movers_ > kMaxWalls) movers_ = size_;
  const auto movers = scene.filters.first(movers_);
  movers_collide_ =
      std::ranges::all_of(movers, [&](const Filter& f) { return AreSame(f, movers[0]); }) &&
      (movers_ == 0 || scene.MayCollide(0, 0));
  second_class_ = SecondClassOf(scene, movers_);
  middle_ = MiddleOf(scene.boxes.first(movers_));
  free_.clear();
  for (Id id = 0; id < movers_; ++id)
    if (!scene.filters[id].is_fixed) free_.push_back(id);
}

bool Bodies::AllSleep(const Scene& scene) const {
  return !scene.is_asleep.empty() &&
         std::memchr(scene.is_asleep.data(), 0, scene.is_asleep.size()) == nullptr;
}

void Bodies::MeasureRoom(const Scene& scene) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  room_ = {{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
  bounds_.clear();
  others_.clear();
  for (auto wall = static_cast<Id>(movers_); wall < scene.size; ++wall)
    (Bound(scene.boxes[wall], middle_, room_) ? bounds_ : others_).push_back(wall);
}

void Bodies::MeetWalls(const Scene& scene, const Kernels& kernels, PairBuffer& pairs) {
  MeasureRoom(scene);
  if (!bounds_.empty()) {
    outside_.resize(movers_);
    const std::size_t count =
        kernels.find_outside(scene.boxes.data(), movers_, room_, outside_.data());
    MeetBounds(scene, std::span(outside_).first(count), pairs);
  }
  MeetOthers(scene, kernels, pairs);
}

void Bodies::MeetBounds(const Scene& scene, std::span<const Id> movers, PairBuffer& pairs) const {
  for (const Id mover : movers)
    for (const Id wall : bounds_)
      if (Overlap(scene.boxes[mover], scene.boxes[wall]) && scene.MayCollide(mover, wall))
        pairs.Add({mover, wall});
}

void Bodies::MeetOthers(const Scene& scene, const Kernels& kernels, PairBuffer& pairs) const {
  const std::size_t before = pairs.size();
  for (std::size_t at = 0; at < others_.size();) {
    const Id wall = others_[at];
    // Planes often share one box, infinite on all sides; such walls are tested together.
    std::size_t end = at + 1;
    while (end < others_.size() && others_[end] == wall + (end - at) &&
           AreSame(scene.boxes[others_[end]], scene.boxes[wall]) &&
           AreSame(scene.filters[others_[end]], scene.filters[wall]))
      ++end;
    if (HasFewFree()) {
      for (const Id id : free_)
        for (std::size_t i = at; i < end; ++i)
          if (Overlap(scene.boxes[id], scene.boxes[others_[i]])) pairs.Add({id, others_[i]});
    } else if (!movers_collide_ || (movers_ > 0 && scene.MayCollide(0, wall))) {
      kernels.meet_wall(scene.boxes.data(), movers_, scene.boxes[wall], wall, end - at,
                        pairs.sink());
    }
    at = end;
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
