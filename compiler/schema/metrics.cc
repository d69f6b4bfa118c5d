#include "compiler/schema/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <span>
#include <variant>
#include <vector>

#include "compiler/schema/series.h"

namespace cdb::schema {
namespace {

using enum Fold;

// clang-format off
constexpr ErrorInfo kErrors[] = {
    {.kind = ErrorKind::kPosition, .name = "position", .series = "accuracy/position_series", .metric = "position",
     .unit = "", .doc = "distance from the true position, in sizes of the object; root mean square over objects and samples",
     .needs_truth = true, .to_horizon = true, .fold = kRms, .on_soft = true},
    {.kind = ErrorKind::kVelocity, .name = "velocity", .series = "accuracy/velocity_series", .metric = "velocity",
     .unit = "m/s", .doc = "difference from the true velocity; root mean square over objects and samples",
     .needs_truth = true, .to_horizon = true, .fold = kRms, .on_soft = true},
    {.kind = ErrorKind::kRotation, .name = "rotation", .series = "accuracy/rotation_series", .metric = "rotation",
     .unit = "rad", .doc = "angle between the orientation and the true one; root mean square over objects and samples",
     .needs_truth = true, .to_horizon = true, .fold = kRms},
    {.kind = ErrorKind::kEnergy, .name = "energy", .series = "accuracy/energy_series", .metric = "energy",
     .unit = "", .doc = "kinetic and potential energy minus the true energy, over the energy of the scene; root mean square over samples",
     .needs_truth = true, .to_horizon = false, .fold = kRms, .on_soft = true},
    {.kind = ErrorKind::kMomentum, .name = "momentum", .series = "accuracy/momentum_series", .metric = "momentum",
     .unit = "", .doc = "total momentum of all objects minus the true one, over the largest sum of their m|v|; root mean square over samples",
     .needs_truth = true, .to_horizon = false, .fold = kRms, .on_soft = true},
    {.kind = ErrorKind::kAngularMomentum, .name = "angular_momentum", .series = "accuracy/angular_momentum_series", .metric = "angular_momentum",
     .unit = "", .doc = "total angular momentum about the common centre of mass minus the true one, over the largest sum of those of the objects; root mean square over samples",
     .needs_truth = true, .to_horizon = false, .fold = kRms, .on_soft = true},
    {.kind = ErrorKind::kPenetration, .name = "penetration", .series = "accuracy/penetration_series", .metric = "penetration",
     .unit = "", .doc = "mean depth of the contacts that overlap, in sizes of the smaller object; mean over samples",
     .needs_truth = false, .to_horizon = false, .fold = kMean},
    {.kind = ErrorKind::kPenetrationMax, .name = "penetration_max", .series = "accuracy/penetration_max_series", .metric = "penetration",
     .unit = "", .doc = "deepest contact, in sizes of the smaller object; largest over samples",
     .needs_truth = false, .to_horizon = false, .fold = kMax},
    {.kind = ErrorKind::kHeight, .name = "height", .series = "accuracy/height_series", .metric = "height",
     .unit = "", .doc = "mean height of the objects minus the true one, in mean sizes; root mean square over samples",
     .needs_truth = true, .to_horizon = false, .fold = kRms, .on_soft = true},
    {.kind = ErrorKind::kHeightW1, .name = "height_w1", .series = "accuracy/height_w1_series", .metric = "height",
     .unit = "", .doc = "Wasserstein distance W1 between the distribution of heights and the true one, in mean sizes; mean over samples",
     .needs_truth = true, .to_horizon = false, .fold = kMean, .on_soft = true},
    {.kind = ErrorKind::kContacts, .name = "contacts", .series = "accuracy/contacts_series", .metric = "contacts",
     .unit = "", .doc = "number of contact points minus the true number, over the true number; root mean square over samples",
     .needs_truth = true, .to_horizon = false, .fold = kRms},
    {.kind = ErrorKind::kPairsMissed, .name = "pairs_missed", .series = "accuracy/pairs_missed_series", .metric = "pairs",
     .unit = "", .doc = "pairs of objects whose exact boxes overlap and that the broad phase does not list, over all pairs that overlap; mean over samples",
     .needs_truth = false, .to_horizon = false, .fold = kMean},
    {.kind = ErrorKind::kPairsPhantom, .name = "pairs_phantom", .series = "accuracy/pairs_phantom_series", .metric = "pairs",
     .unit = "", .doc = "pairs that the broad phase lists although their exact boxes do not overlap, over all pairs that overlap; mean over samples",
     .needs_truth = false, .to_horizon = false, .fold = kMean},
    {.kind = ErrorKind::kDepthError, .name = "depth_error", .series = "accuracy/depth_error_series", .metric = "geometry",
     .unit = "", .doc = "difference between the deepest contact point of an overlap and the exact depth, in sizes of the smaller object; mean over overlaps with a contact point, then over samples",
     .needs_truth = false, .to_horizon = false, .fold = kMeanOfSome},
    {.kind = ErrorKind::kNormalError, .name = "normal_error", .series = "accuracy/normal_error_series", .metric = "geometry",
     .unit = "rad", .doc = "angle between the normal of the deepest contact point of an overlap and the exact normal, if that is unique; mean over overlaps, then over samples",
     .needs_truth = false, .to_horizon = false, .fold = kMeanOfSome},
    {.kind = ErrorKind::kContactsMissed, .name = "contacts_missed", .series = "accuracy/contacts_missed_series", .metric = "geometry",
     .unit = "", .doc = "exact overlaps without a contact point, over all exact overlaps; mean over samples",
     .needs_truth = false, .to_horizon = false, .fold = kMeanOfSome},
};
// clang-format on

}  // namespace

std::span<const ErrorInfo> Errors() { return kErrors; }
std::span<const Metric> Metrics() {
  static const std::vector<Metric> metrics = [] {
    std::vector<Metric> words;
    for (const ErrorInfo& error : kErrors)
      if (words.empty() || words.back().name != error.metric)
        words.push_back({error.metric, error.on_soft});
    return words;
  }();
  return metrics;
}

namespace {

/// `names`, and those of the rows of a table.
std::vector<std::string_view> NamesOf(std::vector<std::string_view> names, const auto& table) {
  for (const auto& row : table) names.push_back(row.name);
  return names;
}

}  // namespace

const std::vector<ResultNames>& ReservedNames() {
  static const std::vector<ResultNames> names = {
      {"a dimension of the results",
       NamesOf({"rep", "contact_row", "contact_side", "xyz"},
               std::span(kDimensions).first(static_cast<std::size_t>(Dimension::kSample)))},
      {"a dimension of the results",
       NamesOf({}, std::span(kDimensions).subspan(static_cast<std::size_t>(Dimension::kQuery)))},
      {"a series of the results", NamesOf({}, kSeries)},
      {"an array of contacts in the results",
       {"contact_body", "contact_point", "contact_normal", "contact_distance", "contact_first"}},
      {"a fact of each run in the results",
       NamesOf({"status", "verdict", "first_bad_cycle", "bad_objects", "n_cycles", "started",
                "load_average", "noise", "noise_cause", "state_hash", "run_id", "host", "message",
                "omitted", "needs", "criterion", "checked", "unchecked"},
               kRunScalars)},
      {"a group of the results", {"run", "accuracy", "provenance", "sampled", "requirements"}},
      {"an array of /accuracy in the results", {"sample", "horizon", "step_size", "truth"}, true},
  };
  return names;
}

std::optional<std::string> FindNameClash(std::string_view axis,
                                         std::span<const ErrorInfo* const> errors) {
  for (const ResultNames& row : ReservedNames())
    if (std::ranges::find(row.names, axis) != row.names.end() &&
        (!row.only_with_errors || !errors.empty()))
      return std::string(row.kind);
  for (const ErrorInfo* error : errors)
    for (const char* ending : {"", "_floor", "_series"})
      if (axis == fmt::format("{}{}", error->name, ending))
        return fmt::format("an error of accuracy.metrics {}", error->metric);
  return std::nullopt;
}

}  // namespace cdb::schema
