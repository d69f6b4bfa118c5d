// Escaped bodies of `skin`: bodies whose boxes have left their fat boxes. They get larger fat
// boxes, or are looked up in every cycle. Walls that bound the room are candidates of the bodies
// whose fat boxes reach them.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "library/detectors/builtin/skin.h"

namespace cdb::builtin {
namespace {

/// The most times that a body gets a larger fat box in one list; after that it is untracked.
constexpr std::uint8_t kMostRegrowths = 2;
/// The most candidates that a larger fat box may have.
constexpr std::size_t kMostNear = 24;
/// A body that is further outside its fat box than this fraction of the box's longest side has been
/// moved elsewhere.
constexpr double kFarAway = 0.5;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool Overlap(const kernels::FatBox& fat, const Box& box) {
  return fat.lower[0] <= box.upper.x && box.lower.x <= fat.upper[0] &&
         fat.lower[1] <= box.upper.y && box.lower.y <= fat.upper[1] &&
         fat.lower[2] <= box.upper.z && box.lower.z <= fat.upper[2];
}
bool Overlap(const kernels::FatBox& a, const kernels::FatBox& b) {
  for (int axis = 0; axis < 3; ++axis)
    if (!(a.lower[axis] <= b.upper[axis] && b.lower[axis] <= a.upper[axis])) return false;
  return true;
}

/// True if the fat box lies inside the room without touching its sides.
bool LiesInside(const kernels::FatBox& fat, const Box& room) {
  const auto inside = [](float lower, float upper, double least, double most) {
    return static_cast<double>(lower) > least && static_cast<double>(upper) < most;
  };
  return inside(fat.lower[0], fat.upper[0], room.lower.x, room.upper.x) &&
         inside(fat.lower[1], fat.upper[1], room.lower.y, room.upper.y) &&
         inside(fat.lower[2], fat.upper[2], room.lower.z, room.upper.z);
}

/// The last term exceeds the rounding error of a normal float. Infinity is unchanged.
float Below(double x) { return static_cast<float>(x < kInfinity ? x - std::fabs(x) * 0x1p-23 : x); }
float Above(double x) {
  return static_cast<float>(x > -kInfinity ? x + std::fabs(x) * 0x1p-23 : x);
}

Pair Ordered(Id a, Id b) { return {std::min(a, b), std::max(a, b)}; }

/// The fat box enlarged to contain a box that left it, with the same margin again. Nullopt if the
/// body was moved elsewhere or its box is NaN.
std::optional<kernels::FatBox> Larger(const kernels::FatBox& fat, const Box& box) {
  const double lower[3] = {box.lower.x, box.lower.y, box.lower.z};
  const double upper[3] = {box.upper.x, box.upper.y, box.upper.z};
  double out = 0, slack = 0, side = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(lower[axis] <= upper[axis])) return std::nullopt;
    const double low = fat.lower[axis], high = fat.upper[axis];
    out = std::max({out, low - lower[axis], upper[axis] - high});
    slack = std::max(slack, (high - low - (upper[axis] - lower[axis])) / 2);
    side = std::max(side, high - low);
  }
  if (!(out <= kFarAway * side && side < kInfinity)) return std::nullopt;
  const double margin = std::max(slack, 2 * out);
  kernels::FatBox larger;
  for (int axis = 0; axis < 3; ++axis) {
    const float low = Below(lower[axis] - margin), high = Above(upper[axis] + margin);
    larger.lower[axis] = fat.lower[axis] <= low ? fat.lower[axis] : low;
    larger.upper[axis] = fat.upper[axis] >= high ? fat.upper[axis] : high;
  }
  return larger;
}

}  // namespace

/// Lists the bodies that have left their fat boxes, in order. Each thread searches a part of them.
std::size_t Skin::FindEscaped(const Scene& scene, const SkinAwake* awake) {
  if (awake != nullptr && age_ > 0 && awake->HaveFewMoved())
    return FindEscapedOfMoved(scene, *awake);
  const std::size_t movers = bodies_.movers();
  const auto find = [&](std::size_t begin, std::size_t end) {
    return kernels_.find_escaped(scene.boxes.data() + begin, list_->fat.data() + begin, end - begin,
                                 escaped_.data() + begin);
  };
  found_in_part_.resize(parts_.most());
  const unsigned parts =
      parts_.ForEach(kReadCost * static_cast<double>(movers), 0, movers, PastBoxes::kBlock,
                     [&](unsigned part, std::size_t begin, std::size_t end) {
                       found_in_part_[part] = {begin, find(begin, end)};
                     });
  std::size_t count = found_in_part_[0].count;
  for (const auto& [begin, size] : std::span(found_in_part_).first(parts).subspan(1))
    for (std::size_t i = 0; i < size; ++i)
      escaped_[count++] = static_cast<Id>(escaped_[begin + i] + begin);
  return count;
}

/// The same if few bodies may have moved since the last cycle. Of the others, only the untracked
/// ones are outside their fat boxes, as they were then.
std::size_t Skin::FindEscapedOfMoved(const Scene& scene, const SkinAwake& awake) {
  may_be_escaped_.assign(escaped_.begin(),
                         escaped_.begin() + static_cast<std::ptrdiff_t>(untracked_));
  awake.ForEachMoved([&](Id id) {
    if (id < bodies_.movers()) may_be_escaped_.push_back(id);
  });
  std::ranges::sort(may_be_escaped_);
  const auto twice = std::ranges::unique(may_be_escaped_);
  may_be_escaped_.erase(twice.begin(), twice.end());
  const auto has_left = [&](Id id) {
    Id first = 0;
    return kernels_.find_escaped(&scene.boxes[id], &list_->fat[id], 1, &first) == 1;
  };
  const auto end = std::ranges::copy_if(may_be_escaped_, escaped_.begin(), has_left).out;
  return static_cast<std::size_t>(end - escaped_.begin());
}

/// Finds the bodies that have left their fat boxes and tracks them; false if a new list costs less.
bool Skin::TrackEscaped(const Scene& scene, const SkinAwake* awake) {
  const std::size_t movers = bodies_.movers();
  const double limit = kListCost * static_cast<double>(movers);
  const auto is_too_much = [&](std::size_t escaped) {
    return escape_cost_ + CostOfEscaped(escaped, std::min(escaped, untracked_)) > limit;
  };
  std::size_t escaped = FindEscaped(scene, awake);
  if (is_too_much(escaped)) {
    if (!builder_.is_half_done()) return false;
    double budget = SkinListBuilder::kUnlimited;
    builder_.Advance(scene, bodies_, cycle_, budget);
    work_ += SkinListBuilder::kUnlimited - budget;
    UseNewList(scene);
    escaped = FindEscaped(scene, awake);
    if (is_too_much(escaped)) return false;
  }
  untracked_ = RegrowEscaped(scene, escaped);
  const double cost = CostOfEscaped(escaped, untracked_);
  cost_ += cost;
  work_ += cost;
  const double cost_of_escapes =
      cost + kTestCost * static_cast<double>(list_->candidates.size() - made_);
  escape_cost_ += cost_of_escapes;
  // Bodies that turned round while the list was built escape in its first cycle; they do not
  // predict later escapes.
  last_escape_cost_ = age_ > 0 ? cost_of_escapes : 0;
  return true;
}

/// Pairs (id, other) of all other bodies whose fat boxes overlap `box`. Valid until the next call.
std::span<const Pair> Skin::Near(const kernels::FatBox& box, Id id) {
  raw_.Clear();
  list_->grid.QueryOne(box, id, raw_.sink());
  const std::span<Pair> found = raw_.pairs();
  const auto rest = std::ranges::remove(found, id, &Pair::b);
  return found.first(found.size() - rest.size());
}

/// Gives an escaped body a larger fat box. False if the body becomes untracked instead, because it
/// was moved elsewhere, has escaped too often or would have too many candidates.
bool Skin::Regrow(const Scene& scene, Id id) {
  if (regrowths_[id] == kMostRegrowths) return false;
  std::vector<kernels::FatBox>& fat = list_->fat;
  const kernels::FatBox old = fat[id];
  const auto larger = Larger(old, scene.boxes[id]);
  const std::span<const Pair> near = larger ? Near(*larger, id) : std::span<const Pair>();
  if (!larger || near.size() > kMostNear || !list_->grid.Grow(id, *larger)) {
    regrowths_[id] = kMostRegrowths;
    return false;
  }
  ++regrowths_[id];
  fat[id] = *larger;
  AddWallsOf(scene, id, &old);
  // Pairs whose fat boxes overlapped before are candidates already.
  for (const auto& [self, other] : near)
    if (!Overlap(old, fat[other]) && scene.MayCollide(id, other))
      list_->candidates.Add(Ordered(id, other));
  return true;
}

/// Gives escaped bodies larger fat boxes. Returns the number of untracked ones, which are moved to
/// the front of `escaped_`.
std::size_t Skin::RegrowEscaped(const Scene& scene, std::size_t count) {
  std::size_t untracked = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Id id = escaped_[i];
    if (!Regrow(scene, id)) escaped_[untracked++] = id;
  }
  return untracked;
}

// Untracked bodies contribute the pairs whose fat boxes do not overlap; the others are candidates.
// Pairs of two untracked bodies are found separately, because neither is inside its fat box.
void Skin::AppendUntracked(const Scene& scene, kernels::PairBuffer& pairs) {
  const std::vector<kernels::FatBox>& fat = list_->fat;
  const std::span<const Id> untracked = std::span(escaped_).first(untracked_);
  const auto put = [&](Id a, Id b, const auto& other_fat) {
    if (Overlap(scene.boxes[a], scene.boxes[b]) && !Overlap(fat[a], other_fat) &&
        scene.MayCollide(a, b))
      pairs.Add(Ordered(a, b));
  };
  untracked_boxes_.clear();
  for (const Id id : untracked) is_untracked_[id] = 1;
  for (const Id id : untracked) {
    const Box& box = scene.boxes[id];
    untracked_boxes_.push_back(box);
    for (const Id wall : bodies_.bounds()) put(id, wall, scene.boxes[wall]);
    for (const auto& [self, other] : Near(kernels::Around(box, kernels_), id))
      if (!is_untracked_[other]) put(self, other, fat[other]);
  }
  for (const Id id : untracked) is_untracked_[id] = 0;
  raw_.Clear();
  untracked_grid_.Build(untracked_boxes_.data(), untracked_);
  untracked_grid_.QueryPart(0, 1, raw_.sink());
  for (const auto& [a, b] : raw_.pairs()) put(untracked[a], untracked[b], fat[untracked[b]]);
}

/// Recomputes the candidates that involve walls if the walls have moved.
void Skin::FollowWalls(const Scene& scene) {
  const std::size_t movers = bodies_.movers();
  const std::span<const Box> walls = scene.boxes.subspan(movers);
  const std::span<Box> past = std::span(list_->past.boxes).subspan(movers);
  if (walls.empty() || std::memcmp(walls.data(), past.data(), walls.size_bytes()) == 0) return;
  std::ranges::copy(walls, past.begin());
  kernels::PairBuffer& candidates = list_->candidates;
  changes_.Replace(candidates.pairs());
  const auto rest = std::ranges::remove_if(candidates.pairs(),
                                           [&](const Pair& pair) { return pair.b >= movers; });
  candidates.Cut(candidates.size() - rest.size());
  AddWalls(scene);
  made_ = std::min(made_, candidates.size());
}

void Skin::AddWalls(const Scene& scene) {
  if (bodies_.bounds().empty()) return;
  for (const Id id : bodies_.free()) AddWallsOf(scene, id, nullptr);
}

/// Adds the pairs of a body and the walls that bound the room and overlap its fat box, except those
/// that overlap `known`.
void Skin::AddWallsOf(const Scene& scene, Id id, const kernels::FatBox* known) {
  const kernels::FatBox& fat = list_->fat[id];
  if (LiesInside(fat, bodies_.room())) return;
  for (const Id wall : bodies_.bounds()) {
    const Box& box = scene.boxes[wall];
    if (Overlap(fat, box) && (known == nullptr || !Overlap(*known, box)) &&
        scene.MayCollide(id, wall))
      list_->candidates.Add({id, wall});
  }
}

}  // namespace cdb::builtin
