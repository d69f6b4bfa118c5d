#include "library/detectors/exact_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

namespace cdb::detectors {
namespace {

struct Row {
  Box box;
  Id body;
};

using Component = double Vec3::*;

/// The axis along which the finite boxes are most spread relative to their size, so that few
/// overlap.
Component BestAxis(const std::vector<Row>& rows) {
  Component best = &Vec3::x;
  double best_crowding = INFINITY;
  for (const Component axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    double length = 0, least = INFINITY, most = -INFINITY;
    for (const Row& row : rows) {
      const double lower = row.box.lower.*axis, upper = row.box.upper.*axis;
      if (!std::isfinite(upper - lower)) continue;
      length += upper - lower;
      least = std::min(least, lower);
      most = std::max(most, upper);
    }
    const double crowding = most > least ? length / (most - least) : INFINITY;
    if (crowding < best_crowding) {
      best = axis;
      best_crowding = crowding;
    }
  }
  return best;
}

}  // namespace

std::vector<Pair> ExactPairs(const Scene& scene, const PairFilter& asked) {
  std::vector<Row> rows;
  rows.reserve(scene.size);
  for (Id body = 0; body < scene.size; ++body) {
    const Box& box = scene.boxes[body];
    if (Overlap(box, box)) rows.push_back({box, body});  // false if a coordinate is NaN
  }
  const Component axis = BestAxis(rows);
  std::ranges::sort(
      rows, [axis](const Row& a, const Row& b) { return a.box.lower.*axis < b.box.lower.*axis; });
  std::vector<Pair> pairs;
  for (auto a = rows.begin(); a != rows.end(); ++a)
    for (auto b = a + 1; b != rows.end() && b->box.lower.*axis <= a->box.upper.*axis; ++b)
      if (Overlap(a->box, b->box) && scene.MayCollide(a->body, b->body))
        pairs.push_back({std::min(a->body, b->body), std::max(a->body, b->body)});
  if (asked) std::erase_if(pairs, [&](const Pair& pair) { return !asked(pair); });
  std::ranges::sort(pairs);
  return pairs;
}

PairFaults ComparePairs(const Scene& scene, std::vector<Pair> found, const PairFilter& asked) {
  std::erase_if(found, [&](const Pair& pair) {
    return !scene.MayCollide(pair.a, pair.b) || (asked && !asked(pair));
  });
  return ComparePairs(ExactPairs(scene, asked), std::move(found));
}

PairFaults ComparePairs(const std::vector<Pair>& exact, std::vector<Pair> found) {
  std::ranges::sort(found);
  const std::size_t listed = found.size();
  found.erase(std::unique(found.begin(), found.end()), found.end());
  PairFaults faults = {.exact = exact.size(), .duplicate = listed - found.size()};
  std::vector<Pair> rest;
  std::ranges::set_difference(exact, found, std::back_inserter(rest));
  faults.missed = rest.size();
  if (!rest.empty()) faults.first_missed = rest.front();
  rest.clear();
  std::ranges::set_difference(found, exact, std::back_inserter(rest));
  faults.false_positives = rest.size();
  return faults;
}

std::string OverlapText(const Scene& scene, const Pair& pair) {
  const auto vector = [](const Vec3& at) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", at.x, at.y, at.z);
  };
  const auto text = [&](const Box& box) { return vector(box.lower) + " to " + vector(box.upper); };
  const Box &a = scene.boxes[pair.a], &b = scene.boxes[pair.b];
  const auto overlap = [&](Component axis) {
    return std::min(a.upper.*axis, b.upper.*axis) - std::max(a.lower.*axis, b.lower.*axis);
  };
  return fmt::format(
      "bodies {} and {}, whose boxes {} and {} overlap by {:.3g} x {:.3g} x {:.3g} m", pair.a,
      pair.b, text(a), text(b), overlap(&Vec3::x), overlap(&Vec3::y), overlap(&Vec3::z));
}

}  // namespace cdb::detectors
