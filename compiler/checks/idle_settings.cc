#include "compiler/checks/idle_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/expectation.h"
#include "compiler/analysis/model.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/configure/configuration.h"
#include "compiler/evaluate/sweeps.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/scenario/layers.h"
#include "compiler/schema/schema.h"

namespace cdb::checks {
namespace {

using schema::IsZero;

bool IsStill(const plan::Group& group) {
  return analysis::PathOf(group) == nullptr && IsZero(group.settings.Get("linear_velocity")) &&
         IsZero(group.settings.Get("angular_velocity"));
}

}  // namespace

void IdleSettings::Look(configure::Configuration& configuration, const scenario::ParameterKey& key,
                        bool is_idle, const std::string& message, const std::string& help) {
  if (!configuration.IsSet(key)) return;
  if (!is_idle)
    useful_.insert(key);
  else if (!idle_.contains(key))
    idle_.emplace(key, Finding{configuration.SpanOf(key, benchmark_), message, help});
}

void IdleSettings::Add(configure::Configuration& configuration, const plan::Scene& scene) {
  for (const plan::Group& group : scene.groups) {
    // What soft bodies cannot have is an error.
    if (group.settings.Count("quantity") == 0 || analysis::IsSoft(group)) continue;
    for (const auto velocity :
         {schema::GroupParameter("linear_velocity"), schema::GroupParameter("angular_velocity")}) {
      if (IsZero(group.settings.Get(velocity))) continue;
      Look(configuration, {group.name, velocity.get()}, group.settings.WordOr("mass") == "fixed",
           fmt::format("'{}' is fixed, and {} does not move it", group.name, velocity.name()),
           "remove it, or write mass kinematic: such objects move with their velocity, whatever "
           "they meet");
    }
    for (const auto exponent : {schema::GroupParameter("e1"), schema::GroupParameter("e2")})
      Look(configuration, {group.name, exponent.get()},
           std::ranges::none_of(analysis::TypesOf(group.settings),
                                [](const schema::Value& type) {
                                  const schema::Word* word = schema::AsWord(type);
                                  return word != nullptr &&
                                         word->text == schema::kSuperellipsoidType;
                                }),
           fmt::format("'{}' has no superellipsoids, and {} has no effect", group.name,
                       exponent.name()),
           "write type superellipsoid, or remove it");
    const std::string_view mass = group.settings.WordOr("mass");
    for (const auto push : {schema::GroupParameter("force"), schema::GroupParameter("torque")})
      if (!IsZero(group.settings.Get(push)))
        Look(configuration, {group.name, push.get()},
             mass == "fixed" || mass == analysis::kKinematicWord,
             fmt::format("'{}' is {}, and no {} moves it", group.name, mass, push.name()),
             fmt::format("give it a mass, or remove the {}", push.name()));
    if (!IsZero(group.settings.Get("spinning_friction")))
      Look(configuration, {group.name, schema::GroupParameter("spinning_friction").get()},
           std::ranges::all_of(scene.groups,
                               [](const plan::Group& other) {
                                 return IsZero(other.settings.Get("rolling_friction"));
                               }),
           "Bullet applies spinning friction only at contacts that also have rolling friction",
           "add a rolling_friction, however small: rolling_friction 1e-6");
    if (analysis::HasKinematic(group))
      Look(configuration, {group.name, schema::GroupParameter("mass").get()}, IsStill(group),
           fmt::format("'{}' is kinematic, and nothing moves it", group.name),
           "give it a velocity that is not 0, or location path(\"motion.csv\"); or write mass "
           "fixed");
  }
  for (const plan::Joint& joint : scene.joints) {
    if (!scene.HoldsObjects(joint)) continue;
    const auto number = [&](schema::GroupParameter parameter) {
      const schema::Number* value = schema::AsNumber(joint.settings.Get(parameter));
      return value == nullptr ? std::nullopt : std::optional(value->AsReal());
    };
    const auto sought = number("joints.motor.position"), lower = number("joints.limits.lower"),
               upper = number("joints.limits.upper");
    if (!sought || !lower || !upper) continue;
    Look(
        configuration, {joint.name, schema::GroupParameter("joints.motor.position").get()},
        *sought < *lower || *sought > *upper,
        fmt::format("the motor of '{}' seeks {:.6g}, and its limits are {:.6g} and {:.6g}: it will "
                    "push against one of them",
                    joint.name, *sought, *lower, *upper),
        "write a position within the limits");
  }
  for (const auto parameter :
       {schema::WorldParameter("detector"), schema::WorldParameter("narrow_phase"),
        schema::WorldParameter("pair_order"), schema::WorldParameter("threads")})
    Look(configuration, {"", parameter.get()},
         analysis::HasConfigurations(scene) && scene.world.WordOr("configurations.by") == "lanes",
         fmt::format("lanes check the configurations, and {} has no effect", parameter.name()),
         "remove it, or write configurations.by detector");
  if (scene.world.WordOr("coordinates") == "reduced")
    Look(configuration, {"", schema::WorldParameter("coordinates").get()},
         scene.PulledGroup().empty(), "the scene has no joints, so it has no reduced coordinates",
         "remove it, or join the objects: links { … } or joints { … }");
  // These have a warning already.
  if (std::ranges::any_of(scene.groups, [](const plan::Group& group) {
        return analysis::HasKinematic(group) && IsStill(group);
      }))
    return;
  const std::string_view said = scene.world.WordOr("expect");
  if (said == "rest" || said == "energy")
    Look(configuration, {"", schema::WorldParameter("expect").get()},
         analysis::ExpectationOf(scene) == analysis::Expectation::kDriven,
         fmt::format("'expect {}' has no effect here: a schedule or kinematic objects drive the "
                     "scene, so that {}",
                     said,
                     said == "rest" ? "it need not rest" : "its energy may change at any time"),
         "remove it");
}

void IdleSettings::Report() const {
  for (const auto& [key, finding] : idle_)
    if (!useful_.contains(key))
      diagnostics_.Report(scenario::kNoEffect, finding.span, finding.message, finding.help);
}

namespace {

constexpr std::size_t kMostValuesNamed = 3;

bool Holds(const text::Span& outer, const text::Span& inner) {
  return outer.source == inner.source && outer.begin <= inner.begin && inner.end <= outer.end;
}

/// `quantity 5, 6 or 7`, `quantity 5, 6, 7 or any of 4 more`.
std::string ValuesText(const plan::Axis& axis, const std::vector<std::size_t>& values) {
  std::string text = axis.name;
  const std::size_t named = std::min(values.size(), kMostValuesNamed);
  for (std::size_t i = 0; i < named; ++i) {
    const plan::Coordinate& value = axis.values[values[i]];
    const bool is_last = i + 1 == values.size();
    text += i == 0 ? " " : is_last ? " or " : ", ";
    const auto* real = std::get_if<double>(&value);
    text += real != nullptr ? schema::FormatReal(*real) : std::get<std::string>(value);
  }
  if (values.size() > named) text += fmt::format(" or any of {} more", values.size() - named);
  return text;
}

class UnreachedValues {
 public:
  UnreachedValues(const scenario::Scenario& scenario, const scenario::BenchmarkRef& benchmark,
                  const grid::Grid& grid, dsl::Diagnostics& diagnostics)
      : scenario_(scenario), benchmark_(benchmark), grid_(grid), diagnostics_(diagnostics) {}

  void Report() {
    const std::vector<plan::Axis>& axes = grid_.head.axes;
    std::vector<std::vector<bool>> is_reached;
    for (const plan::Axis& axis : axes) is_reached.emplace_back(axis.values.size(), false);
    for (const grid::Block& block : grid_.blocks)
      for (std::size_t a = 0; a < axes.size(); ++a) {
        const grid::Remaining remaining = grid::RemainingBy(block, {a});
        for (std::size_t v = 0; v < remaining.counts.size(); ++v)
          if (remaining.counts[v] > 0) is_reached[a][block.places[a][v]] = true;
      }
    for (std::size_t a = 0; a < axes.size(); ++a) {
      std::vector<std::size_t> missed;
      for (std::size_t v = 0; v < is_reached[a].size(); ++v)
        if (!is_reached[a][v]) missed.push_back(v);
      if (!missed.empty()) ReportAxis(axes[a], missed);
    }
  }

 private:
  void ReportAxis(const plan::Axis& axis, const std::vector<std::size_t>& missed) {
    if (const dsl::Cases* cases = CasesOf(axis.name)) {
      for (const dsl::Case& one : cases->cases)
        for (const std::size_t value : missed)
          if (axis.values[value] == plan::Coordinate(one.name.text))
            Warn(one.name.span, fmt::format("no run is in the case '{}'", one.name.text),
                 "remove it, or change `skip`");
      return;
    }
    const auto place = SweepOf(axis.name);
    if (place && Holds(benchmark_.benchmark->span, *place))
      Warn(*place, "no run has " + ValuesText(axis, missed),
           "remove it from the sweep, or change `skip`");
  }

  void Warn(const text::Span& span, const std::string& what, const std::string& help) {
    diagnostics_.Report(scenario::kUnreachable, span,
                        what + ": `skip` skips every point that has it", help);
  }

  /// The cases in the benchmark itself that make the axis; null if there are none.
  const dsl::Cases* CasesOf(const std::string& axis) const {
    for (const dsl::Statement& statement : benchmark_.benchmark->block.statements)
      if (const auto* cases = std::get_if<dsl::Cases>(&statement.what))
        if ((cases->name ? cases->name->text : "case") == axis) return cases;
    return nullptr;
  }

  /// The location of a sweep of the axis, in any case.
  std::optional<text::Span> SweepOf(const std::string& axis) const {
    dsl::Diagnostics said_before;
    const scenario::LayeredBenchmark layered(scenario_, benchmark_, said_before);
    configure::Point chosen(layered.case_axes().size(), 0);
    std::vector<std::size_t> extents;
    for (const scenario::CaseAxis& cases : layered.case_axes())
      extents.push_back(cases.names.size());
    do {
      const configure::Configuration configuration(scenario_, layered.Lay(chosen), said_before);
      for (const configure::SweepAxis& sweep : configuration.axes())
        if (sweep.name == axis) return sweep.span;
    } while (configure::Advance(chosen, extents));
    return std::nullopt;
  }

  const scenario::Scenario& scenario_;
  const scenario::BenchmarkRef& benchmark_;
  const grid::Grid& grid_;
  dsl::Diagnostics& diagnostics_;
};

/// The settings and lets of a block by their full names, with the locations of these names.
using Definitions = std::map<std::string, text::Span>;

void Collect(const dsl::Block& block, const std::string& outer, Definitions& definitions) {
  for (const dsl::Statement& statement : block.statements) {
    if (const auto* let = std::get_if<dsl::Let>(&statement.what)) {
      definitions.emplace("let " + scenario::Joined(outer, let->name.text), let->name.span);
    } else if (const auto* setting = std::get_if<dsl::Setting>(&statement.what)) {
      definitions.emplace(scenario::Joined(outer, setting->path.text), setting->path.span);
    } else if (const auto* group = std::get_if<dsl::Group>(&statement.what)) {
      Collect(group->block,
              group->label ? group->label->text : scenario::Joined(outer, group->kind.text),
              definitions);
    }
  }
}

/// Reports a setting outside cases that every case overrides.
void ReportOverridden(const dsl::Block& block, dsl::Diagnostics& diagnostics) {
  Definitions outside;
  Collect(block, "", outside);
  for (const dsl::Statement& statement : block.statements) {
    const auto* cases = std::get_if<dsl::Cases>(&statement.what);
    if (cases == nullptr || cases->cases.empty()) continue;
    std::vector<Definitions> inside;
    for (const dsl::Case& one : cases->cases) Collect(one.block, "", inside.emplace_back());
    for (const auto& [name, span] : outside) {
      const std::string& wanted = name;
      if (!std::ranges::all_of(inside, [&](const auto& one) { return one.contains(wanted); }))
        continue;
      diagnostics.Report(scenario::kUnreachable, span,
                         fmt::format("no run has this value: every case sets '{}'", name),
                         "remove it here, or from a case",
                         {{inside[0].at(name), "the first case sets it here"}});
    }
  }
}

void ReportUnusedLets(const dsl::Block& block, const grid::Grid& grid,
                      dsl::Diagnostics& diagnostics) {
  for (const dsl::Statement& statement : block.statements) {
    if (const auto* group = std::get_if<dsl::Group>(&statement.what)) {
      ReportUnusedLets(group->block, grid, diagnostics);
    } else if (const auto* let = std::get_if<dsl::Let>(&statement.what)) {
      const dsl::Zip* zip = let->value->zip.get();
      const auto& axis = zip != nullptr ? zip->axis : let->value->axis;
      const std::string& name = axis             ? axis->text
                                : zip != nullptr ? zip->names[0].text
                                                 : let->name.text;
      const bool is_axis = std::ranges::any_of(
          grid.head.axes, [&](const plan::Axis& made) { return made.name == name; });
      if (!is_axis) ReportUnusedSweep(*let, diagnostics);
    }
  }
}

}  // namespace

void ReportUnusedSweep(const dsl::Let& let, dsl::Diagnostics& diagnostics) {
  if (evaluate::IsSweep(*let.value))
    diagnostics.Report(scenario::kUnreachable, let.name.span,
                       fmt::format("nothing uses '{}', so its sweep makes no axis", let.name.text),
                       "set a parameter to it, or remove it");
}

void ReportUnreachable(const scenario::Scenario& scenario, const scenario::BenchmarkRef& benchmark,
                       const grid::Grid& grid, dsl::Diagnostics& diagnostics) {
  UnreachedValues(scenario, benchmark, grid, diagnostics).Report();
  ReportOverridden(benchmark.benchmark->block, diagnostics);
  ReportUnusedLets(benchmark.benchmark->block, grid, diagnostics);
}

}  // namespace cdb::checks
