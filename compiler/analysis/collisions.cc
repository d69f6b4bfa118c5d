#include "compiler/analysis/collisions.h"

#include <algorithm>

namespace cdb::analysis {
namespace {

bool Allows(const plan::Group& group, std::string_view name) {
  return group.settings.Lists("collides_with", "all") ||
         group.settings.Lists("collides_with", name);
}

}  // namespace

Collisions::Collisions(const plan::Scene& scene) {
  const std::vector<plan::Group>& groups = scene.groups;
  for (const plan::Group& a : groups) {
    walls_.push_back(Allows(a, kWallsWord));
    for (const plan::Group& b : groups) touches_.push_back(Allows(a, b.name) && Allows(b, a.name));
  }
  std::vector<std::size_t> firsts;  // the first group of each class
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const auto same =
        std::ranges::find_if(firsts, [&](std::size_t first) { return AreAlike(i, first); });
    classes_.push_back(static_cast<std::size_t>(same - firsts.begin()));
    if (same == firsts.end()) firsts.push_back(i);
  }
  class_count_ = firsts.size();
}

bool Collisions::AreAlike(std::size_t group, std::size_t other) const {
  if (walls_[group] != walls_[other]) return false;
  for (std::size_t i = 0; i < walls_.size(); ++i)
    if (MayTouch(group, i) != MayTouch(other, i)) return false;
  return true;
}

}  // namespace cdb::analysis
