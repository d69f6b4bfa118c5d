#include "compiler/checks/scene_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "compiler/analysis/expectation.h"
#include "compiler/analysis/joints.h"
#include "compiler/analysis/population.h"
#include "compiler/analysis/queries.h"
#include "compiler/analysis/reference.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/time_table.h"
#include "compiler/analysis/trace.h"
#include "compiler/checks/configuration_checks.h"
#include "compiler/plan/clock.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/series.h"
#include "dsl/text/check.h"

namespace cdb::checks {

namespace {

/// Whether there is a floor, and a constant acceleration straight towards it.
bool HasFloorBelow(const plan::Scene& scene) {
  const Eigen::Vector3d* pull =
      schema::AsVector(scene.world.Get(schema::WorldParameter("acceleration")));
  return scene.world.WordOr("world.walls") != "none" && pull != nullptr && pull->x() == 0 &&
         pull->z() == 0 && pull->y() < 0;
}

}  // namespace

bool SceneChecks::Pass(configure::Configuration& configuration, const plan::Scene& scene) {
  return CheckCounts(configuration, scene) && CheckMeasurement(configuration, scene) &&
         CheckKinds(configuration, scene) && CheckOmit(configuration, scene) &&
         CheckAccuracy(configuration, scene);
}

bool SceneChecks::PassConfigurations(configure::Configuration& configuration, plan::Scene& scene) {
  std::vector<LaidFault> faults =
      LayConfigurations(configuration.scenario(), configuration.layers(), scene);
  Report(configuration, faults);
  if (!faults.empty() || !CheckCounts(configuration, scene) ||
      !CheckMeasurement(configuration, scene))
    return false;
  faults = FindFaultsOfConfigurations(scene);
  Report(configuration, faults);
  return faults.empty();
}

bool SceneChecks::PassTraced(configure::Configuration& configuration, plan::Scene& scene) {
  return Trace(configuration, scene) && CheckCounts(configuration, scene) &&
         CheckMeasurement(configuration, scene);
}

// Turns the scene into one of its trace. False if a setting cannot be used with a trace.
bool SceneChecks::Trace(configure::Configuration& configuration, plan::Scene& scene) {
  std::string why;
  const auto facts = configuration.scenario().TraceAt(analysis::TraceOf(scene)->path, why);
  CDB_CHECK(facts);
  const auto faults = LayTrace(configuration.layers(), *facts, scene);
  Report(configuration, faults);
  return faults.empty();
}

void SceneChecks::Report(configure::Configuration& configuration,
                         const std::vector<LaidFault>& faults) {
  for (const LaidFault& fault : faults) {
    if (!unlaid_.emplace(fault.key, fault.word).second) continue;
    text::Span span = configuration.SpanOf(fault.key, benchmark_);
    if (!fault.word.empty()) {
      span = configuration.SpanOfWord(fault.key, fault.word);
    } else if (fault.kind == &scenario::kContradiction && configuration.IsSet(fault.key)) {
      span = configuration.layers().settings.at(fault.key).node->path.span;
    }
    diagnostics_.Report(*fault.kind, span, fault.message, fault.help);
  }
}

// Counts are of one thread. Runs whose instructions are counted are executed by Valgrind. The
// height of a heap is that above the floor.
bool SceneChecks::CheckMeasurement(configure::Configuration& configuration,
                                   const plan::Scene& scene) {
  const bool counts_events = scene.world.Lists("record", "counters"),
             counts_instructions = plan::CountsInstructions(scene),
             has_threads = scene.world.Count("threads") > 1;
  std::vector<LaidFault> faults;
  if (counts_events && has_threads)
    faults.push_back({&scenario::kContradiction,
                      {"", schema::WorldParameter("threads").get()},
                      {},
                      "`record counters` counts the events of one thread",
                      "write threads 1, or remove 'counters'"});
  if (counts_events && counts_instructions)
    faults.push_back(
        {&scenario::kContradiction,
         {"", schema::WorldParameter("record").get()},
         "counters",
         "`clock instructions` runs the engine in Valgrind, whose events are not those of the "
         "engine",
         "remove 'counters', or use `clock time`"});
  if (counts_instructions && has_threads)
    faults.push_back({&scenario::kContradiction,
                      {"", schema::WorldParameter("threads").get()},
                      {},
                      "`clock instructions` counts those of one thread",
                      "write threads 1, or use `clock time`"});
  if (counts_instructions && scene.world.WordOr("memory").empty())
    faults.push_back({&scenario::kContradiction,
                      {"", schema::WorldParameter("memory").get()},
                      {},
                      "`memory` cannot limit runs with `clock instructions`, as Valgrind needs "
                      "memory, too",
                      "remove it, or use `clock time`"});
  if (scene.world.Lists("record", "repose") && !HasFloorBelow(scene))
    faults.push_back({&scenario::kContradiction,
                      {"", schema::WorldParameter("record").get()},
                      "repose",
                      "the angle of repose is that of a heap on the floor, and the scene has no "
                      "floor, or no constant gravity along -y",
                      "write `world { walls floor }` and `acceleration (0, -9.81, 0)`, or remove "
                      "'repose'"});
  Report(configuration, faults);
  return faults.empty();
}

// Limits on several parameters together.
bool SceneChecks::CheckCounts(configure::Configuration& configuration, const plan::Scene& scene) {
  const std::uint64_t objects = scene.ObjectCount();
  const std::uint64_t bodies = analysis::BodyCount(scene);
  if (bodies > 2147483647) {
    diagnostics_.Report(scenario::kCapacity, benchmark_,
                        fmt::format("{} objects are more than a run can have", objects),
                        "the limit is 2147483647, walls included");
    return false;
  }
  const bool places_good = CheckPlaces(configuration, scene);
  const bool moves_good = CheckMotion(configuration, scene);
  if (!CheckLinks(configuration, scene) || !places_good || !moves_good) return false;
  if (!CheckJoints(configuration, scene) || !CheckQueries(configuration, scene)) return false;
  if (!CheckTimeTables(configuration, scene)) return false;
  if (!CheckCollisions(configuration, scene)) return false;
  bool holds = true;
  using DetectorParameter = schema::ParameterRef<false, schema::ValueKind::kWord>;
  for (const auto parameter : {DetectorParameter("detector"), DetectorParameter("narrow_phase")}) {
    const std::string_view word = scene.world.WordOr(parameter);
    const auto detector = schema::FindDetector(word, scene.plugins);
    if (!detector || detector->Holds(bodies)) continue;
    holds = false;
    if (!std::exchange(capacity_reported_, true))
      diagnostics_.Report(
          scenario::kCapacity, configuration.SpanOf({"", parameter.get()}, benchmark_),
          fmt::format("'{}' handles at most {} bodies, walls included, but there are {}", word,
                      detector->max_bodies, bodies),
          fmt::format("skip when quantity > {} and {} == {}, or use {}",
                      detector->max_bodies - (bodies - objects), parameter.name(), word,
                      parameter.name() == "detector" ? "sap32" : "bullet"));
  }
  return holds;
}

// `at` and `pair` fix the number of objects.
bool SceneChecks::CheckPlaces(configure::Configuration& configuration, const plan::Scene& scene) {
  bool good = true;
  for (const plan::Group& group : scene.groups) {
    const schema::Call* location = schema::AsCall(group.settings.Get("location"));
    const std::uint64_t quantity = group.settings.Count("quantity");
    const bool is_at = location != nullptr && location->name == "at";
    const bool is_pair = location != nullptr && location->name == "pair";
    if (analysis::PosesOf(group) != nullptr || analysis::PathOf(group) != nullptr)
      good = CheckTable(configuration, scene, group) && good;
    if (!is_at && !is_pair) continue;
    const std::uint64_t places = is_pair                          ? 2
                                 : schema::ListsPoints(*location) ? location->arguments.size()
                                                                  : 1;
    // A quantity of 0 leaves a group out, except for `pair`, which needs two objects.
    if (quantity == places || (is_at && quantity == 0)) continue;
    good = false;
    if (!misplaced_.emplace(group.name, location->name).second) continue;
    const std::string count = places == 1   ? "one object"
                              : places == 2 ? "two objects"
                                            : fmt::format("{} objects", places);
    diagnostics_.Report(
        scenario::kCapacity,
        configuration.SpanOf({group.name, schema::GroupParameter("location").get()}, benchmark_),
        fmt::format("'{}' places {}, but the quantity of {} is {}", location->name, count,
                    group.name, quantity),
        is_pair ? "write quantity 2"
                : fmt::format("remove the quantity, or list {} point{}: at((0, 0, 0), (1, 2, 3))",
                              quantity, quantity == 1 ? "" : "s"));
  }
  return good;
}

// A table has one line for each object, and no setting may repeat or contradict its columns.
bool SceneChecks::CheckTable(configure::Configuration& configuration, const plan::Scene& scene,
                             const plan::Group& group) {
  analysis::PoseFault why;
  const bool is_path = analysis::PathOf(group) != nullptr;
  const schema::Call& poses = is_path ? *analysis::PathOf(group) : *analysis::PosesOf(group);
  const auto facts = configuration.scenario().PosesAt(poses, why);
  CDB_CHECK(facts);
  const std::string& file = std::get<schema::Text>(schema::ArgumentOf(poses, "file")).text;
  const auto report = [&](schema::GroupParameter parameter, const dsl::DiagnosticKind& kind,
                          const std::string& message, std::string help) {
    if (misplaced_.emplace(group.name, message).second)
      diagnostics_.Report(kind, configuration.SpanOf({group.name, parameter.get()}, benchmark_),
                          message, std::move(help));
    return false;
  };
  const std::uint64_t quantity = group.settings.Count("quantity");
  if (quantity != facts->count && quantity != 0)
    return report("location", scenario::kCapacity,
                  fmt::format("'{}' {} {} object{}, but the quantity of {} is {}", file,
                              is_path ? "is the path of" : "has the poses of", facts->count,
                              facts->count == 1 ? "" : "s", group.name, quantity),
                  is_path ? "remove the quantity; another object needs its own group and path"
                          : "remove the quantity, or name another file");
  if (is_path) WarnOfMissedPath(configuration, scene, group, *facts);
  struct Given {
    schema::GroupParameter parameter;
    bool is_given;
  };
  const Given given[] = {{"orientation", facts->has_orientation},
                         {"linear_velocity", facts->has_linear_velocity},
                         {"angular_velocity", facts->has_angular_velocity}};
  for (const auto& [parameter, is_given] : given)
    if (is_given && configuration.IsSet({group.name, parameter.get()}))
      return report(parameter, scenario::kContradiction,
                    fmt::format("'{}' already sets the {} of each object of {}", file,
                                parameter.name(), group.name),
                    is_path && parameter.name() == "linear_velocity"
                        ? "take it out here"
                        : "remove it here, or its columns from the file");
  return true;
}

// A path in Unix times begins half a century after the run.
void SceneChecks::WarnOfMissedPath(configure::Configuration& configuration,
                                   const plan::Scene& scene, const plan::Group& group,
                                   const analysis::PoseFacts& facts) {
  const schema::Call& path = *analysis::PathOf(group);
  const double end =
      scene.world.Real("timestep") * static_cast<double>(scene.world.Count("cycles"));
  if (facts.first_time == facts.last_time || (facts.first_time < end && facts.last_time > 0) ||
      std::get<schema::Word>(schema::ArgumentOf(path, "then")).text == "repeat")
    return;
  const std::string message = fmt::format(
      "the path of {} lasts from {} s to {} s, but the run from 0 s to {} s: it does not move",
      group.name, schema::FormatReal(facts.first_time), schema::FormatReal(facts.last_time),
      schema::FormatReal(end));
  if (misplaced_.emplace(group.name, message).second)
    diagnostics_.Report(
        scenario::kNoEffect,
        configuration.SpanOf({group.name, schema::GroupParameter("location").get()}, benchmark_),
        message,
        "write start: first to count from its first time; if its times are not in "
        "s, write their unit: columns: \"t=t [ns], …\"");
}

// A word with arguments must name existing groups.
bool SceneChecks::CheckGroupsInCalls(configure::Configuration& configuration,
                                     const plan::Scene& scene, const plan::Group& group) {
  std::vector<std::string_view> names;
  for (const plan::Group& other : scene.groups) names.push_back(other.name);
  bool good = true;
  for (const auto& [name, value] : group.settings) {
    const schema::Call* call = schema::AsCall(value);
    if (call == nullptr || schema::ListsPoints(*call)) continue;
    for (const schema::Parameter& argument : schema::FindParametrisedWord(call->name)->arguments) {
      if (argument.word_source != schema::WordSource::kGroups) continue;
      const std::string& word = std::get<schema::Word>(ArgumentOf(*call, argument.name)).text;
      if (std::ranges::find(names, word) != names.end()) continue;
      good = false;
      if (!misplaced_.emplace(group.name, word).second) continue;
      ReportUnknownGroup(
          configuration.SpanOf({group.name, schema::FindParameter(name, true)}, benchmark_), word,
          names);
    }
  }
  return good;
}

void SceneChecks::ReportUnknownGroup(const text::Span& span, const std::string& word,
                                     const std::vector<std::string_view>& names) {
  const std::string_view near = dsl::DidYouMean(word, names);
  diagnostics_.Report(scenario::kUnknownName, span, fmt::format("there is no group '{}'", word),
                      near.empty() ? fmt::format("there are {}", fmt::join(names, ", "))
                                   : fmt::format("did you mean '{}'?", near));
}

// `collides_with` must name existing groups, in no more classes than Bullet can tell apart.
bool SceneChecks::CheckCollisions(configure::Configuration& configuration,
                                  const plan::Scene& scene) {
  const auto parameter = schema::GroupParameter("collides_with");
  std::vector<std::string_view> names = {analysis::kWallsWord};
  for (const plan::Group& group : scene.groups) names.push_back(group.name);
  const bool is_ambiguous = std::ranges::count(names, analysis::kWallsWord) > 1;
  bool good = true;
  for (const plan::Group& group : scene.groups) {
    good = CheckGroupsInCalls(configuration, scene, group) && good;
    for (const std::string& word : group.settings.Words("collides_with")) {
      if (parameter.get()->HasWord(word)) continue;
      const bool is_known = std::ranges::find(names, word) != names.end();
      if (is_known && !(is_ambiguous && word == analysis::kWallsWord)) continue;
      good = false;
      if (!misplaced_.emplace(group.name, word).second) continue;
      const text::Span span = configuration.SpanOfWord({group.name, parameter.get()}, word);
      if (is_known)
        diagnostics_.Report(scenario::kContradiction, span,
                            "'walls' could mean those of the world or the group of that name",
                            "give the group another name");
      else
        ReportUnknownGroup(span, word, names);
    }
  }
  const std::size_t classes = analysis::Collisions(scene).ClassCount();
  if (!good || classes <= analysis::kMostCollisionClasses) return good;
  if (misplaced_.emplace("", "collides_with").second)
    diagnostics_.Report(
        scenario::kCapacity, benchmark_,
        fmt::format("collides_with makes {} kinds of groups, but Bullet supports {}", classes,
                    analysis::kMostCollisionClasses),
        "let more groups touch the same groups");
  return false;
}

// Objects that links cannot hold together.
bool SceneChecks::CheckLinks(configure::Configuration& configuration, const plan::Scene& scene) {
  bool good = true;
  for (const plan::Group& group : scene.groups) {
    if (!group.HasLinks()) continue;
    const schema::Call* location = schema::AsCall(group.settings.Get("location"));
    std::string why, hint;
    if (group.settings.WordOr("mass") == "fixed") {
      why = "never move, so links would have no effect";
      hint = "give them a mass";
    } else if (analysis::HasKinematic(group)) {
      why = "are kinematic, so links would have no effect";
      hint = "give them a mass";
    } else if (group.settings.Count("quantity") == 1 && !group.settings.On("links.anchor")) {
      why = "are one object, and without links.anchor there is nothing to link it to";
      hint = "write quantity 2 or links.anchor on";
    } else if (location != nullptr && location->name == "pile") {
      why = "settle in a pile, which cannot have links";
      hint = "write another location, line for example";
    }
    if (why.empty()) continue;
    good = false;
    if (!misplaced_.emplace(group.name, why).second) continue;
    diagnostics_.Report(
        scenario::kContradiction,
        configuration.SpanOf({group.name, schema::GroupParameter("links.type").get()}, benchmark_),
        fmt::format("the {} {}", group.name, why), hint);
  }
  return good;
}

// Joints that cannot be made.
bool SceneChecks::CheckJoints(configure::Configuration& configuration, const plan::Scene& scene) {
  std::vector<std::string_view> names = {plan::kWorldWord};
  for (const plan::Group& group : scene.groups) names.push_back(group.name);
  bool good = true;
  for (const plan::Joint& joint : scene.joints) {
    const auto fault = analysis::FindJointFault(scene, joint);
    if (!fault) continue;
    good = false;
    if (!misplaced_.emplace(joint.name, fault->message).second) continue;
    using enum analysis::JointFault::Kind;
    const text::Span span = configuration.SpanOf({joint.name, fault->parameter.get()}, benchmark_);
    if (fault->kind == kUnknownGroup)
      ReportUnknownGroup(span, fault->message, names);
    else
      diagnostics_.Report(fault->kind == kQuantity ? scenario::kCapacity : scenario::kContradiction,
                          span, fault->message, fault->help);
  }
  const auto reduced = good ? analysis::FindReducedFault(scene) : std::nullopt;
  if (!reduced) return good;
  if (misplaced_.emplace(reduced->group, reduced->message).second)
    diagnostics_.Report(
        scenario::kContradiction,
        configuration.SpanOf(
            {reduced->group, reduced->parameter},
            configuration.SpanOf({"", schema::WorldParameter("coordinates").get()}, benchmark_)),
        reduced->message, reduced->help);
  return false;
}

// Tables of values over time that cannot be read.
bool SceneChecks::CheckTimeTables(configure::Configuration& configuration,
                                  const plan::Scene& scene) {
  const auto fault = analysis::FindTimeTableFault(scene, [&](const std::string& path) {
    std::string why;
    return configuration.scenario().TextOf(path, why);
  });
  if (!fault) return true;
  if (misplaced_.emplace(fault->owner, fault->message).second)
    diagnostics_.Report(scenario::kOutOfDomain,
                        configuration.SpanOf({fault->owner, fault->parameter}, benchmark_),
                        fault->message, fault->help);
  return false;
}

// Queries that cannot be asked.
bool SceneChecks::CheckQueries(configure::Configuration& configuration, const plan::Scene& scene) {
  bool good = true;
  for (const plan::Queries& queries : scene.queries) {
    const auto fault = analysis::FindQueryFault(queries);
    if (!fault) continue;
    good = false;
    if (misplaced_.emplace(queries.name, fault->message).second)
      diagnostics_.Report(scenario::kContradiction,
                          configuration.SpanOf({queries.name, fault->parameter.get()}, benchmark_),
                          fault->message, fault->help);
  }
  return good;
}

// What soft bodies, or objects that come and go, cannot have, and settings that only they have.
bool SceneChecks::CheckKinds(configure::Configuration& configuration, const plan::Scene& scene) {
  auto fault = analysis::FindSoftFault(scene);
  if (!fault) fault = analysis::FindPopulationFault(scene);
  if (!fault) return true;
  if (!misplaced_.emplace(fault->group, fault->message).second) return false;
  const scenario::ParameterKey key{fault->group, fault->parameter};
  diagnostics_.Report(scenario::kContradiction,
                      fault->word.empty() || !configuration.IsSet(key)
                          ? configuration.SpanOf(key, benchmark_)
                          : configuration.SpanOfWord(key, fault->word),
                      fault->message, fault->help);
  return false;
}

// `omit` must not name a component that the scene needs.
bool SceneChecks::CheckOmit(configure::Configuration& configuration, const plan::Scene& scene) {
  if (scene.world.Lists("omit", "none")) return true;
  bool good = true;
  for (const analysis::PruningDecision& part : analysis::AnalysePruning(scene)) {
    if (part.decision != analysis::Decision::kKept ||
        analysis::RequestFor(scene, part.component) != analysis::PruningRequest::kByName)
      continue;
    good = false;
    const std::string_view name = schema::InfoOf(part.component).name;
    const text::Span span =
        configuration.SpanOfWord({"", schema::WorldParameter("omit").get()}, name);
    if (!refused_.emplace(span.source, span.begin, part.component).second) continue;
    diagnostics_.Report(
        scenario::kNeeded, span, fmt::format("'{}' cannot be omitted: {}", name, part.why),
        "remove it from the list; omit auto omits everything that a scene does not need");
  }
  return good;
}

// Settings of accuracy need metrics; samples must fall on cycles, at one interval in all runs.
bool SceneChecks::CheckAccuracy(configure::Configuration& configuration, const plan::Scene& scene) {
  const auto& settings = configuration.layers().settings;
  const scenario::ParameterKey metrics{"", schema::WorldParameter("accuracy.metrics").get()};
  const auto said = std::ranges::find_if(settings, [](const auto& setting) {
    return setting.first.second->name.starts_with("accuracy.");
  });
  if (said != settings.end() && !settings.contains(metrics)) {
    if (std::exchange(inaccurate_, true)) return false;
    diagnostics_.Report(scenario::kContradiction, said->second.node->path.span,
                        "accuracy without metrics computes nothing",
                        "name the errors: accuracy.metrics position, energy");
    return false;
  }
  const auto report = [&](const dsl::DiagnosticKind& kind, const schema::Parameter* parameter,
                          const std::string& message, const std::string& help) {
    if (!std::exchange(inaccurate_, true))
      diagnostics_.Report(kind, configuration.SpanOf({"", parameter}, benchmark_), message, help);
    return false;
  };
  const analysis::AccuracyFault fault = analysis::FindAccuracyFault(scene);
  if (fault.parameter != nullptr)
    return report(scenario::kContradiction, fault.parameter, fault.message, fault.help);
  const auto sampling = analysis::SamplingOf(scene);
  if (!sampling) return true;
  const auto joined = analysis::NeedsReference(scene)
                          ? analysis::FindReducedFault(analysis::ReferenceOf(scene))
                          : std::nullopt;
  if (joined)
    return report(scenario::kContradiction,
                  schema::WorldParameter("accuracy.reference.coordinates").get(),
                  "in the reference run, " + joined->message, joined->help);
  if (analysis::NeedsReference(scene)) {
    // In other coordinates, joints may be what they cannot be there.
    const plan::Scene reference = analysis::ReferenceOf(scene);
    for (const plan::Joint& joint : reference.joints)
      if (const auto fault_there = analysis::FindJointFault(reference, joint))
        return report(scenario::kContradiction,
                      schema::WorldParameter("accuracy.reference.coordinates").get(),
                      "in the reference run, " + fault_there->message, fault_there->help);
  }
  if (!interval_s_) interval_s_ = sampling->interval_s;
  if (*interval_s_ != sampling->interval_s)
    return report(scenario::kMisplacedSweep, schema::WorldParameter("accuracy.interval").get(),
                  "the interval must be the same in every run", "the samples make one axis");
  return true;
}

// Settings that kinematic objects cannot have, those that only they can have, and those of
// surfaces, which cannot move.

namespace {

struct MotionFault {
  schema::GroupParameter parameter;
  std::string message, help;
};

/// Bullet's treatment of a margin differs from shape to shape.
std::optional<MotionFault> FindMarginFault(const plan::Group& group) {
  // The default means no margin here.
  if (!group.settings.Has(*schema::GroupParameter("margin"))) return std::nullopt;
  const schema::Value& given = group.settings.Get("margin");
  return MotionFault{"margin",
                     fmt::format("a surface has no margin, but that of {} is {}", group.name,
                                 schema::ToText(given)),
                     "remove the margin"};
}

std::optional<MotionFault> FindMotionFault(const plan::Group& group) {
  const plan::GroupSettings& settings = group.settings;
  if (settings.Count("quantity") == 0) return std::nullopt;
  if (analysis::HasSurface(settings) && settings.WordOr("mass") != "fixed")
    return MotionFault{
        settings.WordOr("mass") == analysis::kKinematicWord ? schema::GroupParameter("mass")
                                                            : schema::GroupParameter("type"),
        fmt::format("a surface has no inside and does not move, but the mass of {} is {}",
                    group.name, schema::ToText(settings.Get("mass"))),
        "write mass fixed, or type mesh(…) for a solid that moves"};
  if (analysis::HasSurface(settings))
    if (auto fault = FindMarginFault(group)) return fault;
  if (analysis::PathOf(group) != nullptr && settings.WordOr("mass") != analysis::kKinematicWord)
    return MotionFault{
        "location",
        fmt::format("only a kinematic object can move along a path, but the mass of {} is {}",
                    group.name, schema::ToText(settings.Get("mass"))),
        "write mass kinematic"};
  if (!analysis::HasKinematic(group)) return std::nullopt;
  for (const auto parameter :
       {schema::GroupParameter("linear_velocity"), schema::GroupParameter("angular_velocity")})
    if (const schema::Call* schedule = schema::AsCall(settings.Get(parameter)))
      return MotionFault{
          parameter,
          fmt::format("'{}' changes a velocity, but kinematic objects keep theirs", schedule->name),
          "write one velocity, or their motion in a file: location path(\"motion.csv\")"};
  const schema::Call* layout = schema::AsCall(settings.Get("location"));
  if (layout != nullptr && layout->name == "pile")
    return MotionFault{
        "location", fmt::format("the {} are kinematic and cannot settle into a pile", group.name),
        "give them a mass, or another location"};
  return std::nullopt;
}

}  // namespace

bool SceneChecks::CheckMotion(configure::Configuration& configuration, const plan::Scene& scene) {
  bool good = true;
  for (const plan::Group& group : scene.groups) {
    const auto fault = FindMotionFault(group);
    if (!fault) continue;
    good = false;
    if (misplaced_.emplace(group.name, fault->message).second)
      diagnostics_.Report(scenario::kContradiction,
                          configuration.SpanOf({group.name, fault->parameter.get()}, benchmark_),
                          fault->message, fault->help);
  }
  return good;
}

}  // namespace cdb::checks
