#include "compiler/schema/metrics.h"

#include <vector>

#include <algorithm>
#include <functional>
#include <variant>

namespace cdb::schema {
namespace {

using enum Fold;

constexpr bool kTruth = true, kItself = false;
constexpr bool kToHorizon = true, kToEnd = false;

// clang-format off
constexpr ErrorInfo kErrors[] = {
    {ErrorKind::kPosition, "position", "accuracy/position_series", "position", "",
     "distance from the true place, in sizes of the object; root of the mean square over objects and samples", kTruth, kToHorizon, kRms},
    {ErrorKind::kVelocity, "velocity", "accuracy/velocity_series", "velocity", "m/s",
     "difference from the true velocity; root of the mean square over objects and samples", kTruth, kToHorizon, kRms},
    {ErrorKind::kRotation, "rotation", "accuracy/rotation_series", "rotation", "rad",
     "angle between the orientation and the true one; root of the mean square over objects and samples", kTruth, kToHorizon, kRms},
    {ErrorKind::kEnergy, "energy", "accuracy/energy_series", "energy", "",
     "kinetic and potential energy less the true one, over the scene's energy; root of the mean square over samples", kTruth, kToEnd, kRms},
    {ErrorKind::kMomentum, "momentum", "accuracy/momentum_series", "momentum", "",
     "of all objects together less the true one, over the largest sum of their m|v|; root of the mean square", kTruth, kToEnd, kRms},
    {ErrorKind::kAngularMomentum, "angular_momentum", "accuracy/angular_momentum_series", "angular_momentum", "",
     "about the common centre of mass, less the true one, over the largest sum of the objects' own; root of the mean square", kTruth, kToEnd, kRms},
    {ErrorKind::kPenetration, "penetration", "accuracy/penetration_series", "penetration", "",
     "mean depth of the contacts that overlap, in sizes of the smaller object; mean over samples", kItself, kToEnd, kMean},
    {ErrorKind::kPenetrationMax, "penetration_max", "accuracy/penetration_max_series", "penetration", "",
     "deepest contact, in sizes of the smaller object; largest over samples", kItself, kToEnd, kMax},
    {ErrorKind::kHeight, "height", "accuracy/height_series", "height", "",
     "the objects' mean height less the true one, in mean sizes; root of the mean square over samples", kTruth, kToEnd, kRms},
    {ErrorKind::kHeightW1, "height_w1", "accuracy/height_w1_series", "height", "",
     "how far heights have to be moved to be spread as the true ones (W1), in mean sizes; mean over samples", kTruth, kToEnd, kMean},
    {ErrorKind::kContacts, "contacts", "accuracy/contacts_series", "contacts", "",
     "contact points less the true number, over the true number; root of the mean square over samples", kTruth, kToEnd, kRms},
    {ErrorKind::kPairsMissed, "pairs_missed", "accuracy/pairs_missed_series", "pairs", "",
     "pairs of objects whose exact boxes overlap and that the broad phase has not got, over those that overlap; mean over samples", kItself, kToEnd, kMean},
    {ErrorKind::kPairsPhantom, "pairs_phantom", "accuracy/pairs_phantom_series", "pairs", "",
     "pairs that the broad phase has got though their exact boxes do not overlap, over those that overlap; mean over samples", kItself, kToEnd, kMean},
    {ErrorKind::kDepthError, "depth_error", "accuracy/depth_error_series", "geometry", "",
     "deepest contact point of an overlap less the exact depth, in sizes of the smaller object; mean over overlaps that have one, then over samples", kItself, kToEnd, kMeanOfSome},
    {ErrorKind::kNormalError, "normal_error", "accuracy/normal_error_series", "geometry", "rad",
     "angle between its normal and the exact one, where there is only one; mean over overlaps, then over samples", kItself, kToEnd, kMeanOfSome},
    {ErrorKind::kContactsMissed, "contacts_missed", "accuracy/contacts_missed_series", "geometry", "",
     "exact overlaps without a contact point, over all; mean over samples", kItself, kToEnd, kMeanOfSome},
};
// clang-format on

}  // namespace

std::span<const ErrorInfo> Errors() { return kErrors; }
std::span<const Metric> Metrics() {
  static const std::vector<Metric> metrics = [] {
    std::vector<Metric> words;
    for (const ErrorInfo& error : kErrors)
      if (words.empty() || words.back().name != error.metric) words.push_back({error.metric});
    return words;
  }();
  return metrics;
}

}  // namespace cdb::schema
