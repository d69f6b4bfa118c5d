#include "compiler/checks/scene_faults.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string_view>

#include "compiler/lints/lint_facts.h"
#include "compiler/lints/lint_findings.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::checks {
namespace {

using schema::GroupParameter;
using schema::WorldParameter;
using Kind = analysis::SceneFault::Kind;

/// Warns of objects of the default size if all others are smaller than this fraction of it.
constexpr double kSmall = 0.1;

/// Limits of a hinge within these bounds, and multiples of the first, are probably in degrees.
constexpr double kWholeDegrees = 5, kLeastDegrees = 30, kMostDegrees = 720;

/// Beyond this ratio of sizes, an inertia is probably in other units than the parts. Between bodies
/// of equal sizes it is at most 1.73, where all mass is in the corners.
constexpr double kOddSpread = 10;

/// m: the diagonal of a homogeneous box with the inertia that a compound states; nullopt if it
/// states none.
std::optional<double> SpreadOf(const schema::Value& type) {
  const schema::Call* call = schema::AsCall(type);
  if (call == nullptr || call->name != "compound") return std::nullopt;
  const Eigen::Vector3d* moments = schema::AsVector(schema::ArgumentOf(*call, "inertia"));
  if (moments == nullptr) return std::nullopt;
  return std::sqrt(6 * moments->sum());
}

/// All settings that determine the placement of objects, and whether the engine can hold them.
std::string PlacementKey(const plan::Scene& scene) {
  std::string key;
  for (const WorldParameter parameter :
       {WorldParameter("world.side"), WorldParameter("world.walls"), WorldParameter("acceleration"),
        WorldParameter("precision")})
    key += "\n" + plan::CanonicalLine(parameter.name(), scene.world.Get(parameter));
  for (const plan::Group& group : scene.groups) {
    key += "\n" + group.name;
    for (const auto& [name, value] : group.settings) key += "\n" + plan::CanonicalLine(name, value);
  }
  for (const auto& [name, seed] : scene.seeds) key += fmt::format("\n{} {}", name, seed);
  return key;
}

bool NamesClosedForm(const plan::Scene& scene) {
  return scene.world.WordOr("accuracy.closed_form") != "none";
}

std::string DefaultSizeText() {
  return fmt::format("{} {}", GroupParameter("size").get()->DefaultText(),
                     GroupParameter("size").get()->unit);
}

}  // namespace

std::optional<std::optional<analysis::SceneFault>> SceneFaults::Find(
    configure::Configuration& configuration, const plan::Scene& scene) {
  if (const auto fault = FindInModels(configuration, scene)) return fault;
  // The positions depend on the seeds, which follow from `seed`.
  plan::NoteRead(*WorldParameter("seed"));
  const std::uint64_t count = scene.ObjectCount();
  if (NamesClosedForm(scene)) {
    // It depends on most of a scene, so that no two scenes share a result. The square must not
    // overflow.
    pairs_ += count < kMostPairs ? count * count / 2 : kMostPairs + 1;
    if (pairs_ > kMostPairs) return std::nullopt;
    return find_(scene, draws_);
  }
  const auto [known, is_new] = known_.try_emplace(PlacementKey(scene));
  if (!is_new) return known->second;
  objects_ += count;
  if (objects_ <= most_objects_) known->second = find_(scene, draws_);
  return known->second;
}

std::optional<analysis::SceneFault> SceneFaults::FindInModels(
    configure::Configuration& configuration, const plan::Scene& scene) {
  for (const plan::Group& group : scene.groups)
    for (const schema::Value& type : analysis::TypesOf(group.settings)) {
      analysis::ModelFault why;
      const auto model = configuration.scenario().ModelAt(type, why);
      if (!why.cause.empty() && !why.is_missing)
        return analysis::SceneFault{Kind::kPlacement, group.name, why.cause, why.remedy, "type"};
      if (model && group.settings.WordOr("size") == "native")
        FindOddInertia(configuration, group.name, type, model->sides.norm());
      if (!model || model->iou.value_or(1) >= analysis::kGoodFit ||
          !poor_fits_.insert(model->text).second)
        continue;
      diagnostics_.Report(
          scenario::kPoorFit,
          configuration.SpanOf({group.name, schema::GroupParameter("type").get()}, benchmark_),
          fmt::format("the hulls differ from the mesh, so that objects touch where it is not, or "
                      "sink in where it is: {}",
                      model->text),
          fmt::format(
              "allow more hulls, such as `hulls: {}`, or a smaller `error` if it is set, and "
              "look at them in `cdb view`",
              analysis::HullsForGoodFit(model->hulls, *model->iou)));
    }
  return std::nullopt;
}

void SceneFaults::FindOddInertia(configure::Configuration& configuration, const std::string& group,
                                 const schema::Value& type, double across) {
  const auto spread = SpreadOf(type);
  if (!spread || (*spread < kOddSpread * across && across < kOddSpread * *spread) ||
      std::ranges::find(odd_inertias_, group, &OddInertia::group) != odd_inertias_.end())
    return;
  odd_inertias_.push_back(
      {group, *spread, across,
       configuration.SpanOf({group, GroupParameter("type").get()}, benchmark_)});
}

void SceneFaults::ReportOddInertias() const {
  if (odd_inertias_.empty()) return;
  const OddInertia& first = odd_inertias_.front();
  std::string message = fmt::format(
      "the inertia of `{}` is that of a body {:.2g} m across, but its parts are {:.2g} m",
      first.group, first.spread, first.across);
  if (odd_inertias_.size() > 1) {
    std::vector<std::string> others;
    for (const OddInertia& one : std::span(odd_inertias_).subspan(1)) others.push_back(one.group);
    message += fmt::format("; so are those of {}", fmt::join(others, ", "));
  }
  diagnostics_.Report(scenario::kOddInertia, first.span, message,
                      "look at the units: lengths are in m, also those of meshes, and moments of "
                      "inertia in kg m^2");
}

void SceneFaults::Add(configure::Configuration& configuration, const plan::Scene& scene,
                      std::size_t runs) {
  WarnOfEllipsoids(configuration, scene);
  WarnOfDegrees(configuration, scene);
  if (!find_) return;
  WarnOfDefaultSizes(configuration, scene);
  const auto found = Find(configuration, scene);
  if (!found) return;
  looked_at_ += runs;
  const std::optional<analysis::SceneFault>& fault = *found;
  if (!fault) return;
  if (fault->kind == Kind::kPlacement) unplaced_runs_ += runs;
  const auto [at, is_first] = findings_.try_emplace({fault->kind, fault->group});
  Finding& finding = at->second;
  finding.runs += runs;
  if (!is_first) return;
  finding.fault = *fault;
  finding.span = SpanOf(configuration, *fault);
  finding.is_default_size = fault->kind == Kind::kPlacement && !fault->group.empty() &&
                            fault->parameter.empty() &&
                            !configuration.IsSet({fault->group, GroupParameter("size").get()});
}

// The location of the first setting that may be at fault and that the benchmark sets, else of its
// name.
text::Span SceneFaults::SpanOf(configure::Configuration& configuration,
                               const analysis::SceneFault& fault) const {
  std::vector<scenario::ParameterKey> keys;
  if (!fault.parameter.empty())
    keys.push_back({fault.group, schema::FindParameter(fault.parameter, !fault.group.empty())});
  if (fault.kind == Kind::kClosedForm) {
    keys.push_back({"", WorldParameter("accuracy.closed_form").get()});
  } else {
    for (const GroupParameter parameter : {GroupParameter("location"), GroupParameter("size"),
                                           GroupParameter("quantity"), GroupParameter("type")})
      if (!fault.group.empty()) keys.push_back({fault.group, parameter.get()});
    keys.push_back({"", WorldParameter("world.side").get()});
  }
  for (const scenario::ParameterKey& key : keys)
    if (configuration.IsSet(key)) return configuration.SpanOf(key, benchmark_);
  return benchmark_;
}

void SceneFaults::WarnOfDefaultSizes(configure::Configuration& configuration,
                                     const plan::Scene& scene) {
  const GroupParameter size = "size";
  double largest = 0;  // of the groups that set a size
  for (const plan::Group& group : scene.groups)
    if (group.settings.Count("quantity") > 0 && configuration.IsSet({group.name, size.get()}))
      largest = std::max(largest, lints::BoundsOf(group.settings, "size").most);
  for (const plan::Group& group : scene.groups) {
    if (group.settings.Count("quantity") == 0 || configuration.IsSet({group.name, size.get()}))
      continue;
    if (!(largest > 0) || largest > kSmall * lints::BoundsOf(group.settings, "size").least)
      continue;
    if (!default_sizes_.insert(group.name).second) continue;
    diagnostics_.Report(scenario::kDefaultSize,
                        SpanOf(configuration, {Kind::kPlacement, group.name, {}, {}, {}}),
                        fmt::format("the size of `{}` is not set: its objects have the default of "
                                    "{}, and all others have {:.3g} m or less",
                                    group.name, DefaultSizeText(), largest),
                        "set the size");
  }
}

// Where other types stand beside the spheres, sides drawn one by one are what is asked for: cuboids
// would be cubes without them.
void SceneFaults::WarnOfEllipsoids(configure::Configuration& configuration,
                                   const plan::Scene& scene) {
  const GroupParameter size = "size";
  for (const plan::Group& group : scene.groups) {
    const schema::Distribution* drawn = schema::AsDistribution(group.settings.Get(size));
    if (drawn == nullptr || group.settings.WordOr("type") != "sphere" ||
        group.settings.Count("quantity") == 0)
      continue;
    const std::string text = schema::ToText(group.settings.Get(size));
    diagnostics_.Report(scenario::kEllipsoids,
                        configuration.SpanOf({group.name, size.get()}, benchmark_),
                        "each side is drawn separately, so that the spheres are ellipsoids",
                        fmt::format("size same({}) draws one value for all sides", text));
  }
}

void SceneFaults::WarnOfDegrees(configure::Configuration& configuration, const plan::Scene& scene) {
  const GroupParameter orientation = "orientation";
  constexpr double kTurn = 2 * std::numbers::pi;
  for (const plan::Group& group : scene.groups) {
    const auto* angles = std::get_if<Eigen::Vector3d>(&group.settings.Get(orientation));
    if (angles == nullptr || !(angles->norm() > kTurn * (1 + 1e-9)) ||
        group.settings.Count("quantity") == 0)
      continue;
    diagnostics_.Report(
        scenario::kLargeAngle, configuration.SpanOf({group.name, orientation.get()}, benchmark_),
        fmt::format("this turns by {:.4g} rad, more than a full turn", angles->norm()),
        fmt::format("for degrees, write ({}, {}, {}) deg", angles->x(), angles->y(), angles->z()));
  }
  for (const plan::Joint& joint : scene.joints) {
    if (joint.settings.WordOr("joints.type") != "hinge") continue;
    const GroupParameter names[] = {"joints.limits.lower", "joints.limits.upper"};
    const schema::Number* limits[] = {schema::AsNumber(joint.settings.Get(names[0])),
                                      schema::AsNumber(joint.settings.Get(names[1]))};
    const auto is_in_degrees = [](const schema::Number* limit) {
      return limit != nullptr && std::fmod(limit->AsReal(), kWholeDegrees) == 0;
    };
    if (!std::ranges::all_of(limits, is_in_degrees)) continue;
    const double lower = limits[0]->AsReal(), upper = limits[1]->AsReal();
    const double largest = std::max(-lower, upper);
    if (largest < kLeastDegrees || largest > kMostDegrees || !degrees_.insert(joint.name).second)
      continue;
    diagnostics_.Report(
        scenario::kLargeAngle, configuration.SpanOf({joint.name, names[0].get()}, benchmark_),
        fmt::format("joint `{}` has the limits {:.6g} and {:.6g} rad, more than {:.0f} turns",
                    joint.name, lower, upper, std::floor(largest / kTurn)),
        fmt::format("for degrees, write {:.6g} deg and {:.6g} deg; files of robots have radians",
                    lower, upper));
  }
}

void SceneFaults::Report(std::size_t runs) const {
  ReportOddInertias();
  for (const auto& [key, finding] : findings_) {
    const bool is_form = key.first == Kind::kClosedForm;
    const bool fails_everywhere = unplaced_runs_ == runs;
    std::string message = finding.fault.cause, help = finding.fault.remedy;
    if (runs > 1) message += "; in " + lints::CountText(finding.runs, looked_at_, runs);
    if (finding.is_default_size)
      help += fmt::format("{}the size of `{}` is not set, and its default is {}",
                          help.empty() ? "" : "; ", finding.fault.group, DefaultSizeText());
    if (is_form) {
      diagnostics_.Report(scenario::kWrongForm, finding.span, message, help);
    } else if (fails_everywhere) {
      const bool is_value = !finding.fault.parameter.empty();
      diagnostics_.Report(is_value ? scenario::kOutOfDomain : scenario::kCannotPlace, finding.span,
                          message, help);
    } else {
      diagnostics_.Report(scenario::kRunsWillFail, finding.span, "runs will fail: " + message,
                          help);
    }
  }
}

}  // namespace cdb::checks
