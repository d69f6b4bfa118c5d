// Which groups of objects may touch: `collides_with`.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// The word that names the walls among groups.
inline constexpr std::string_view kWallsWord = "walls";

/// Two groups may touch where each one allows the other; walls allow everyone. Names that are no
/// group's allow nobody.
class Collisions {
 public:
  explicit Collisions(const plan::Scene& scene);

  /// Nothing is filtered.
  bool AllMayTouch() const { return class_count_ == 1 && MayTouch(0, 0) && MayTouchWalls(0); }
  /// By the groups' places in the scene.
  bool MayTouch(std::size_t group, std::size_t other) const {
    return touches_[group * walls_.size() + other] != 0;
  }
  bool MayTouchWalls(std::size_t group) const { return walls_[group] != 0; }
  /// Groups of one class may touch the same others. Classes are counted from 0.
  std::size_t ClassOf(std::size_t group) const { return classes_[group]; }
  std::size_t ClassCount() const { return class_count_; }

 private:
  bool AreAlike(std::size_t group, std::size_t other) const;

  std::vector<char> touches_;  ///< a row for each group
  std::vector<char> walls_;
  std::vector<std::size_t> classes_;
  std::size_t class_count_ = 0;
};

/// Bullet's masks have bits for no more.
inline constexpr std::size_t kMostCollisionClasses = 12;

}  // namespace cdb::analysis
