#include "library/queries/scene_tree.h"

#include <cmath>
#include <limits>
#include <optional>

namespace cdb::queries {
namespace {

/// In float, and not less than the number.
float RoundedUp(double number) {
  return std::nextafter(static_cast<float>(number), std::numeric_limits<float>::infinity());
}

/// A tree whose boxes have grown by this factor is built anew.
constexpr double kWorse = 1.5;

}  // namespace

template <typename Real>
std::size_t SceneTree<Real>::Add(const objects::Solid& solid, std::int32_t id) {
  bodies_.push_back({solid, &shapes_.Get(solid), id, Vec<Real>::Zero(), Axes::Identity()});
  boxes_.emplace_back();
  built_cost_ = -1;
  return bodies_.size() - 1;
}

template <typename Real>
void SceneTree<Real>::Move(std::size_t index, const Vec<Real>& position, const Axes& axes) {
  Body& body = bodies_[index];
  body.position = position;
  body.axes = axes;
  has_moved_ = true;
  const LineShape<Real>& shape = *body.shape;
  Vec<Real> reach;
  if (shape.IsEllipsoid())
    reach = (axes * shape.half().asDiagonal()).rowwise().norm();
  else
    reach = axes.cwiseAbs() * shape.half();
  const Vec<Real> centre = position + axes * shape.middle();
  boxes_[index] =
      BoxAround((centre - reach).template cast<double>(), (centre + reach).template cast<double>());
}

template <typename Real>
void SceneTree<Real>::Update() {
  if (built_cost_ >= 0) {
    if (!has_moved_) return;
    has_moved_ = false;
    tree_.Refit(boxes_);
    if (tree_.Cost() <= kWorse * built_cost_) return;
  }
  has_moved_ = false;
  tree_.Build(boxes_);
  built_cost_ = tree_.Cost();
}

template <typename Real>
bool SceneTree<Real>::HitBody(const Body& body, const Ray<Real>& ray, float& limit, Real& most,
                              Hit<Real>& hit) const {
  const Vec<Real> from = body.axes.transpose() * (ray.from - body.position),
                  along = body.axes.transpose() * ray.along;
  bool is_hit = false;
  Vec<Real> normal;
  body.shape->ForChordsOnRay(from, along, limit, [&](const Chord<Real>& chord, Real) {
    if (!(chord.enter >= 0) || chord.enter > most) return;
    is_hit = true;
    most = chord.enter;
    limit = RoundedUp(static_cast<double>(most));
    normal = chord.normal;
  });
  if (is_hit) hit = {body.id, most, (body.axes * normal).normalized()};
  return is_hit;
}

template <typename Real>
bool SceneTree<Real>::HitHalfSpace(const HalfSpace& space, const Ray<Real>& ray, Real most,
                                   Hit<Real>& hit) const {
  Chord<Real> chord;
  chord.Cut(ray.from, ray.along, space.normal, space.offset);
  if (!(chord.enter >= 0) || chord.enter > most || chord.IsNone()) return false;
  hit = {space.id, chord.enter, space.normal};
  return true;
}

template <typename Real>
void SceneTree<Real>::Cast(const Ray<Real>& ray, Hits hits, std::vector<Hit<Real>>& found) const {
  const std::size_t before = found.size();
  Real most = ray.length;
  Hit<Real> hit;
  const auto take = [&] {
    if (hits == Hits::kAll || found.size() == before)
      found.push_back(hit);
    else
      found.back() = hit;
    if (hits == Hits::kClosest) most = hit.distance;
    return hits == Hits::kAny;
  };
  for (const HalfSpace& space : half_spaces_)
    if (HitHalfSpace(space, ray, most, hit) && take()) return;
  float limit = RoundedUp(static_cast<double>(most));
  const WideTree::Ray for_boxes(ray.from.template cast<double>(), ray.along.template cast<double>(),
                                static_cast<double>(ray.length));
  tree_.ForRay(for_boxes, limit, [&](std::size_t index) {
    Real within = most;
    float nearer = limit;
    if (!HitBody(bodies_[index], ray, nearer, within, hit)) return false;
    if (take()) return true;
    if (hits == Hits::kClosest) limit = nearer;
    return false;
  });
}

template <typename Real>
void SceneTree<Real>::Sweep(const Placed& from, const Eigen::Vector3d& along, double length,
                            Hits hits, std::vector<Hit<Real>>& found) const {
  const std::size_t before = found.size();
  double most = length;
  const auto take = [&](std::int32_t id, const std::optional<Touch>& touch) {
    if (!touch) return false;
    if (hits != Hits::kAll) found.resize(before);
    found.push_back(HitOf(id, *touch));
    if (hits == Hits::kClosest) most = touch->distance;
    // Nothing is nearer than what it overlaps.
    return hits == Hits::kAny || (hits == Hits::kClosest && most == 0);
  };
  for (const HalfSpace& space : half_spaces_)
    if (take(space.id, SweepTo(from, along, most, space.exact()))) return;
  const objects::Box box = objects::Bounds(from.solid, Eigen::Quaterniond::Identity());
  const WideTree::Ray ray(from.position + (box.lower + box.upper) / 2, along, length,
                          (box.upper - box.lower) / 2);
  float limit = RoundedUp(most);
  tree_.ForRay(ray, limit, [&](std::size_t index) {
    const Body& body = bodies_[index];
    const bool is_last = take(body.id, SweepTo(from, along, most, body.solid, body.pose()));
    limit = RoundedUp(most);
    return is_last;
  });
}

template <typename Real>
void SceneTree<Real>::Overlap(const Placed& at, Hits hits, std::vector<Hit<Real>>& found) const {
  const auto take = [&](std::int32_t id, const std::optional<Touch>& touch) {
    if (touch) found.push_back(HitOf(id, *touch));
    return touch && hits == Hits::kAny;
  };
  for (const HalfSpace& space : half_spaces_)
    if (take(space.id, DistanceTo(at, 0, space.exact()))) return;
  const objects::Box box = objects::Bounds(at.solid, Eigen::Quaterniond::Identity());
  const float limit = 0;
  tree_.ForNear(BoxAround(at.position + box.lower, at.position + box.upper), limit,
                [&](std::size_t index) {
                  const Body& body = bodies_[index];
                  return take(body.id, DistanceTo(at, 0, body.solid, body.pose()));
                });
}

template <typename Real>
void SceneTree<Real>::Nearest(const Placed& at, double reach, std::vector<Hit<Real>>& found) const {
  const std::size_t before = found.size();
  double most = reach;
  const auto take = [&](std::int32_t id, const std::optional<Touch>& touch) {
    if (touch) {
      found.resize(before);
      found.push_back(HitOf(id, *touch));
      most = touch->distance;
    }
    return most == 0;  // nothing is nearer
  };
  for (const HalfSpace& space : half_spaces_)
    if (take(space.id, DistanceTo(at, most, space.exact()))) return;
  const objects::Box box = objects::Bounds(at.solid, Eigen::Quaterniond::Identity());
  float limit = RoundedUp(most);
  tree_.ForNear(BoxAround(at.position + box.lower, at.position + box.upper), limit,
                [&](std::size_t index) {
                  const Body& body = bodies_[index];
                  const bool is_last = take(body.id, DistanceTo(at, most, body.solid, body.pose()));
                  limit = RoundedUp(most);
                  return is_last;
                });
}

template class SceneTree<float>;
template class SceneTree<double>;

}  // namespace cdb::queries
