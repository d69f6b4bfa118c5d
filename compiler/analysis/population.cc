#include "compiler/analysis/population.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/catalogue.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"

namespace cdb::analysis {
namespace {

using plan::Group;
using plan::Scene;
using schema::GroupParameter;
using schema::WorldParameter;

constexpr GroupParameter kSpawnBatch = "spawn.batch", kBelow = "remove.below",
                         kOutside = "remove.outside", kAfter = "remove.after";

bool IsChanging(const Group& group) {
  return group.settings.Count("quantity") > 0 && (SpawningOf(group) || RemovalOf(group));
}

}  // namespace

std::uint64_t Spawning::DueAt(std::uint64_t cycle, std::uint64_t quantity) const {
  if (cycle < start) return 0;
  const std::uint64_t times = (cycle - start) / every + 1;
  return times > quantity / count ? quantity : std::min(quantity, times * count);
}

std::optional<Spawning> SpawningOf(const Group& group) {
  const schema::Number* count = schema::AsNumber(group.settings.Get(kSpawnBatch));
  if (count == nullptr) return std::nullopt;
  return Spawning{count->AsCount(), group.settings.Count("spawn.every"),
                  group.settings.Count("spawn.start")};
}

std::optional<Removal> RemovalOf(const Group& group) {
  Removal removal;
  if (const schema::Number* below = schema::AsNumber(group.settings.Get(kBelow)))
    removal.below = below->AsReal();
  if (const schema::Number* after = schema::AsNumber(group.settings.Get(kAfter)))
    removal.after = after->AsCount();
  const schema::Value& outside = group.settings.Get(kOutside);
  removal.outside_box = schema::AsCall(outside);
  removal.outside_cube =
      removal.outside_box == nullptr && group.settings.WordOr("remove.outside") == "cube";
  if (!removal.below && !removal.after && !removal.outside_cube && removal.outside_box == nullptr)
    return std::nullopt;
  return removal;
}

const Group* FindChanging(const Scene& scene) {
  const auto found = std::ranges::find_if(scene.groups, IsChanging);
  return found == scene.groups.end() ? nullptr : &*found;
}

bool KnowsChanges(std::string_view detector) {
  const schema::DetectorInfo* info = schema::FindDetector(detector);
  return info != nullptr && info->part.empty();
}

bool ComesOrGoes(const Scene& scene) { return FindChanging(scene) != nullptr; }

namespace {

/// Words of `record` that assume a fixed set of bodies.
struct FixedRecord {
  std::string_view word, why;
};
constexpr FixedRecord kFixedRecords[] = {
    {"boxes", "a trace has the same bodies in every cycle"},
    {"queries", "queries ask the same bodies in every cycle"},
    {"query_errors", "queries ask the same bodies in every cycle"}};

bool MayBeWord(const schema::Value& value) {
  if (schema::AsWord(value) != nullptr) return true;
  const schema::Distribution* drawn = schema::AsDistribution(value);
  return drawn != nullptr && std::ranges::any_of(drawn->arguments, MayBeWord);
}

class PopulationCheck {
 public:
  /// `changing`: the first group with objects that come or go.
  PopulationCheck(const Scene& scene, const Group& changing)
      : scene_(scene), those_(fmt::format("the objects of {} come and go", changing.name)) {}

  using Maybe = std::optional<SettingFault>;

  Maybe FindInWorld() const {
    if (HasConfigurations(scene_))
      return OfWorld("configurations.positions",
                     fmt::format("configurations are of one set of bodies, and {}", those_),
                     "remove spawn and remove, or configurations");
    using WordParameter = schema::ParameterRef<false, schema::ValueKind::kWord>;
    for (const auto parameter : {WordParameter("detector"), WordParameter("narrow_phase")}) {
      const std::string_view name = scene_.world.WordOr(parameter);
      if (name != "own" && name != "bullet" && !KnowsChanges(name))
        return OfWorld(
            parameter,
            fmt::format("'{}' is told of its bodies once, at the start, and {}", name, those_),
            "use a detector of cdb or Bullet (cdb doc detectors)");
    }
    for (const FixedRecord& fixed : kFixedRecords)
      if (scene_.world.Lists("record", fixed.word))
        return OfWorld(
            "record",
            fmt::format("'{}' cannot be recorded: {}, and {}", fixed.word, fixed.why, those_),
            "remove the word", std::string(fixed.word));
    if (!scene_.world.Lists("accuracy.metrics", "none"))
      return OfWorld("accuracy.metrics",
                     fmt::format("errors compare the same objects in two runs, and {}", those_),
                     "remove the metrics");
    const std::string_view expect = scene_.world.WordOr("expect");
    if (expect == "rest" || expect == "energy")
      return OfWorld("expect",
                     fmt::format("the scene cannot {}: {}",
                                 expect == "rest" ? "stay at rest" : "keep its energy", those_),
                     "write expect anything, or remove it");
    return std::nullopt;
  }

  /// In one whose objects come or go.
  Maybe FindIn(const Group& group) const {
    const plan::GroupSettings& settings = group.settings;
    const auto fault = [&](GroupParameter parameter, std::string message, std::string help) {
      return Maybe({group.name, parameter.get(), {}, std::move(message), std::move(help)});
    };
    if (MayBeWord(settings.Get("mass")))
      return fault(
          "mass",
          fmt::format("the objects of {} come and go, and must be free to move", group.name),
          "write a mass or a density");
    for (const auto parameter :
         {GroupParameter("links.type"), GroupParameter("force"), GroupParameter("torque")})
      if (settings.Has(*parameter.get()))
        return fault(parameter,
                     fmt::format("'{}' cannot act on objects that come and go, as those of {}",
                                 parameter.name(), group.name),
                     "remove it");
    for (const auto parameter :
         {GroupParameter("linear_velocity"), GroupParameter("angular_velocity")})
      if (schema::AsCall(settings.Get(parameter)) != nullptr)
        return fault(parameter,
                     fmt::format("schedules do not reach objects that come and go, as those of {}",
                                 group.name),
                     "write the velocity with which they come");
    if (!SpawningOf(group)) return std::nullopt;
    if (settings.WordOr("location") != "uniform")
      return fault("location",
                   fmt::format("objects that spawn, as those of {}, come at places that are drawn "
                               "uniformly from their region",
                               group.name),
                   "remove the location, and write the region");
    const schema::Call* region = schema::AsCall(settings.Get("region"));
    if (region != nullptr && region->name != "box")
      return fault(
          "region",
          fmt::format("the objects of {} spawn in a box that is known at the start", group.name),
          "write region box(…)");
    return std::nullopt;
  }

  /// In one whose objects stay.
  Maybe FindBeside(const Group& group) const {
    for (const auto parameter : {GroupParameter("location"), GroupParameter("region")}) {
      const schema::Call* call = schema::AsCall(group.settings.Get(parameter));
      if (call == nullptr) continue;
      const auto fault = [&](std::string message, std::string help) {
        return Maybe({group.name, parameter.get(), {}, std::move(message), std::move(help)});
      };
      if (call->name == "pile")
        return fault(fmt::format("a pile settles before the first cycle, and {}", those_),
                     "let the objects fall during a warm-up");
      for (const schema::Value& argument : call->arguments) {
        const schema::Word* word = schema::AsWord(argument);
        const Group* named = word == nullptr ? nullptr : scene_.FindGroup(word->text);
        if (named != nullptr && SpawningOf(*named))
          return fault(fmt::format("there are no objects of {} at the start", named->name),
                       "write coordinates");
      }
    }
    return std::nullopt;
  }

  Maybe FindInBlocks() const {
    for (const plan::Joint& joint : scene_.joints)
      for (const std::string_view side :
           {joint.settings.WordOr("joints.parent"), joint.settings.WordOr("joints.child")}) {
        const Group* group = scene_.FindGroup(side);
        if (scene_.HoldsObjects(joint) && group != nullptr && IsChanging(*group))
          return SettingFault{
              joint.name,
              GroupParameter("joints.child").get(),
              {},
              fmt::format("the objects of {} come and go, and no joint holds them", side),
              "remove the joint, or spawn and remove"};
      }
    for (const plan::Queries& queries : scene_.queries)
      if (queries.settings.Count("queries.count") > 0)
        return SettingFault{
            queries.name,
            GroupParameter("queries.type").get(),
            {},
            fmt::format("queries ask the same bodies in every cycle, and {}", those_),
            "remove the queries, or spawn and remove"};
    return std::nullopt;
  }

 private:
  static Maybe OfWorld(WorldParameter parameter, std::string message, std::string help,
                       std::string word = {}) {
    return SettingFault{{}, parameter.get(), std::move(word), std::move(message), std::move(help)};
  }

  const Scene& scene_;
  const std::string those_;
};

/// A setting of how objects spawn, in a group whose objects do not.
std::optional<SettingFault> FindIdleSpawning(const Group& group) {
  if (SpawningOf(group)) return std::nullopt;
  for (const auto parameter : {GroupParameter("spawn.every"), GroupParameter("spawn.start")})
    if (group.settings.Has(*parameter.get()))
      return SettingFault{group.name,
                          parameter.get(),
                          {},
                          fmt::format("all objects of {} are there from the start", group.name),
                          "write how many come at a time: spawn { batch 20 }, or remove it"};
  return std::nullopt;
}

/// The first parameter that makes objects of the group come or go.
const schema::Parameter* ChangingParameter(const Group& group) {
  for (const GroupParameter parameter : {kSpawnBatch, kBelow, kAfter})
    if (schema::AsNumber(group.settings.Get(parameter)) != nullptr) return parameter.get();
  return kOutside.get();
}

}  // namespace

std::optional<SettingFault> FindPopulationFault(const Scene& scene) {
  for (const Group& group : scene.groups)
    if (group.settings.Count("quantity") > 0)
      if (auto idle = FindIdleSpawning(group)) return idle;
  const Group* changing = FindChanging(scene);
  if (changing == nullptr) return std::nullopt;
  if (HasSoft(scene))
    return SettingFault{changing->name,
                        ChangingParameter(*changing),
                        {},
                        "beside soft bodies, no objects come or go",
                        "remove it, or the soft bodies"};
  const PopulationCheck check(scene, *changing);
  if (auto fault = check.FindInWorld()) return fault;
  for (const Group& group : scene.groups) {
    if (group.settings.Count("quantity") == 0) continue;
    if (auto fault = check.FindBeside(group)) return fault;
    if (!IsChanging(group)) continue;
    if (auto fault = check.FindIn(group)) return fault;
  }
  return check.FindInBlocks();
}

}  // namespace cdb::analysis
