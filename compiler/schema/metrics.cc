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
     "distance from the true position, in sizes of the object; root mean square over objects and samples", kTruth, kToHorizon, kRms},
    {ErrorKind::kVelocity, "velocity", "accuracy/velocity_series", "velocity", "m/s",
     "difference from the true velocity; root mean square over objects and samples", kTruth, kToHorizon, kRms},
    {ErrorKind::kRotation, "rotation", "accuracy/rotation_series", "rotation", "rad",
     "angle between the orientation and the true one; root mean square over objects and samples", kTruth, kToHorizon, kRms},
    {ErrorKind::kEnergy, "energy", "accuracy/energy_series", "energy", "",
     "kinetic and potential energy minus the true energy, over the energy of the scene; root mean square over samples", kTruth, kToEnd, kRms},
    {ErrorKind::kMomentum, "momentum", "accuracy/momentum_series", "momentum", "",
     "total momentum of all objects minus the true one, over the largest sum of their m|v|; root mean square over samples", kTruth, kToEnd, kRms},
    {ErrorKind::kAngularMomentum, "angular_momentum", "accuracy/angular_momentum_series", "angular_momentum", "",
     "total angular momentum about the common centre of mass minus the true one, over the largest sum of those of the objects; root mean square over samples", kTruth, kToEnd, kRms},
    {ErrorKind::kPenetration, "penetration", "accuracy/penetration_series", "penetration", "",
     "mean depth of the contacts that overlap, in sizes of the smaller object; mean over samples", kItself, kToEnd, kMean},
    {ErrorKind::kPenetrationMax, "penetration_max", "accuracy/penetration_max_series", "penetration", "",
     "deepest contact, in sizes of the smaller object; largest over samples", kItself, kToEnd, kMax},
    {ErrorKind::kHeight, "height", "accuracy/height_series", "height", "",
     "mean height of the objects minus the true one, in mean sizes; root mean square over samples", kTruth, kToEnd, kRms},
    {ErrorKind::kHeightW1, "height_w1", "accuracy/height_w1_series", "height", "",
     "Wasserstein distance W1 between the distribution of heights and the true one, in mean sizes; mean over samples", kTruth, kToEnd, kMean},
    {ErrorKind::kContacts, "contacts", "accuracy/contacts_series", "contacts", "",
     "number of contact points minus the true number, over the true number; root mean square over samples", kTruth, kToEnd, kRms},
    {ErrorKind::kPairsMissed, "pairs_missed", "accuracy/pairs_missed_series", "pairs", "",
     "pairs of objects whose exact boxes overlap and that the broad phase does not list, over all pairs that overlap; mean over samples", kItself, kToEnd, kMean},
    {ErrorKind::kPairsPhantom, "pairs_phantom", "accuracy/pairs_phantom_series", "pairs", "",
     "pairs that the broad phase lists although their exact boxes do not overlap, over all pairs that overlap; mean over samples", kItself, kToEnd, kMean},
    {ErrorKind::kDepthError, "depth_error", "accuracy/depth_error_series", "geometry", "",
     "difference between the deepest contact point of an overlap and the exact depth, in sizes of the smaller object; mean over overlaps with a contact point, then over samples", kItself, kToEnd, kMeanOfSome},
    {ErrorKind::kNormalError, "normal_error", "accuracy/normal_error_series", "geometry", "rad",
     "angle between the normal of the deepest contact point of an overlap and the exact normal, if that is unique; mean over overlaps, then over samples", kItself, kToEnd, kMeanOfSome},
    {ErrorKind::kContactsMissed, "contacts_missed", "accuracy/contacts_missed_series", "geometry", "",
     "exact overlaps without a contact point, over all exact overlaps; mean over samples", kItself, kToEnd, kMeanOfSome},
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
