// Reads plans; plan_yaml.cc writes them.
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <span>
#include <string_view>
#include <utility>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/expectation.h"
#include "compiler/analysis/joints.h"
#include "compiler/analysis/population.h"
#include "compiler/analysis/queries.h"
#include "compiler/analysis/reference.h"
#include "compiler/analysis/soft.h"
#include "compiler/schema/formula.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "compiler/yaml/plan_yaml.h"
#include "compiler/yaml/short_plan.h"
#include "dsl/text/utf8.h"

namespace cdb::yaml {
namespace {

/// Walks a document; everything unexpected becomes a PlanError with file and line.
class Nodes {
 public:
  explicit Nodes(const std::string& name) : name_(name) {}

  [[noreturn]] void Fail(const YAML::Mark& mark, const std::string& what) const {
    throw PlanError(mark.is_null() ? fmt::format("{}: {}", name_, what)
                                   : fmt::format("{}:{}: {}", name_, mark.line + 1, what));
  }

  YAML::Node Member(const YAML::Node& map, const char* key) const {
    if (!map.IsMap()) Fail(map.Mark(), fmt::format("expected a map with `{}`", key));
    YAML::Node member = map[key];
    if (!member) Fail(map.Mark(), fmt::format("`{}` is missing", key));
    return member;
  }

  const std::string& Text(const YAML::Node& node) const {
    if (!node.IsScalar()) Fail(node.Mark(), "expected a word or a number");
    return node.Scalar();
  }

  double Real(const YAML::Node& node) const {
    const std::string& text = Text(node);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
      Fail(node.Mark(), fmt::format("`{}` is not a finite number", text));
    return value;
  }

  std::uint64_t Count(const YAML::Node& node) const {
    const std::string& text = Text(node);
    const bool hex = text.starts_with("0x");
    const char* begin = text.data() + (hex ? 2 : 0);
    std::uint64_t value = 0;
    const auto [end, error] =
        std::from_chars(begin, text.data() + text.size(), value, hex ? 16 : 10);
    if (error != std::errc{} || end != text.data() + text.size())
      Fail(node.Mark(), fmt::format("`{}` is not a whole number of 64 bits", text));
    return value;
  }

  std::vector<std::size_t> Indices(const YAML::Node& node) const {
    if (!node.IsSequence()) Fail(node.Mark(), "expected a list of indices");
    std::vector<std::size_t> indices;
    for (const YAML::Node& item : node) indices.push_back(Count(item));
    return indices;
  }

  Eigen::Vector3d Vector(const YAML::Node& node) const {
    if (!node.IsSequence() || node.size() != 3) Fail(node.Mark(), "expected three numbers");
    return {Real(node[0]), Real(node[1]), Real(node[2])};
  }

 protected:
  const std::string& name_;
};

class ValueReader : public Nodes {
 public:
  using Nodes::Nodes;

  schema::Value ReadValue(const YAML::Node& node, const schema::Parameter& parameter,
                          std::span<const schema::PluginDetector> plugins = {}) const {
    if (node.IsMap()) {
      if (node.size() == 0) Fail(node.Mark(), "expected a distribution or a word");
      const schema::ParametrisedWord* info =
          schema::FindParametrisedWord(Text(node.begin()->first));
      if (info != nullptr && node.size() > 1)
        Fail(node.Mark(), "expected a distribution or a word");
      if (info != nullptr) return ReadCall(node, *info, parameter);
      if (Text(node.begin()->first) == "formula") return ReadFormula(node, parameter);
      return ReadDistribution(node, parameter);
    }
    if (node.IsScalar() && parameter.type != schema::ParameterType::kWords &&
        !parameter.is_formula && parameter.HasWord(node.Scalar(), plugins))
      return schema::Word{node.Scalar()};
    return ReadConstant(node, parameter);
  }

 private:
  schema::Value ReadConstant(const YAML::Node& node, const schema::Parameter& parameter) const {
    const auto in_domain = [&](double value) {
      if (!parameter.domain.Contains(value))
        Fail(node.Mark(), fmt::format("`{}` takes {}", parameter.name, parameter.Takes()));
      return value;
    };
    switch (parameter.type) {
      case schema::ParameterType::kCount: {
        const std::uint64_t count = Count(node);
        in_domain(static_cast<double>(count));
        return count;
      }
      case schema::ParameterType::kReal:
        return in_domain(Real(node));
      case schema::ParameterType::kSwitch:
        if (Text(node) != "on" && Text(node) != "off")
          Fail(node.Mark(), fmt::format("`{}` takes on or off", parameter.name));
        return Text(node) == "on";
      case schema::ParameterType::kVector: {
        const Eigen::Vector3d vector = Vector(node);
        if (parameter.domain.not_zero && vector.isZero(0))
          Fail(node.Mark(), fmt::format("`{}` takes {}", parameter.name, parameter.Takes()));
        return vector;
      }
      case schema::ParameterType::kRatio: {
        const Eigen::Vector3d parts = Vector(node);
        for (const double part : parts) in_domain(part);
        return schema::Ratio{parts};
      }
      case schema::ParameterType::kWords: {
        if (!node.IsSequence()) Fail(node.Mark(), "expected a list of words");
        schema::WordList words;
        for (const YAML::Node& item : node) {
          const bool is_name = schema::AreNamesOfScene(parameter.word_source);
          if (!is_name && !parameter.HasWord(Text(item))) FailWord(item, parameter);
          words.push_back(Text(item));
        }
        return words;
      }
      case schema::ParameterType::kText:
        return schema::Text{Text(node)};
      case schema::ParameterType::kWord:
        if (schema::AreNamesOfScene(parameter.word_source)) return schema::Word{Text(node)};
        break;
    }
    FailWord(node, parameter);
  }

  schema::Value ReadCall(const YAML::Node& node, const schema::ParametrisedWord& info,
                         const schema::Parameter& parameter) const {
    if (!parameter.TakesCall(info.name))
      Fail(node.Mark(), fmt::format("`{}` takes {}", parameter.name, parameter.Takes()));
    const YAML::Node arguments = node.begin()->second;
    if (info.takes_points && arguments.IsSequence()) {
      schema::Call call{std::string(info.name), {}};
      for (const YAML::Node& point : arguments) call.arguments.emplace_back(Vector(point));
      if (call.arguments.empty()) Fail(node.Mark(), fmt::format("`{}` needs a point", info.name));
      return call;
    }
    const auto is_omitted = [&](const schema::Parameter& argument) {
      return argument.omitted_at_default && !arguments[std::string(argument.name)];
    };
    if (!arguments.IsMap() || arguments.size() + static_cast<std::size_t>(std::ranges::count_if(
                                                     info.arguments, is_omitted)) !=
                                  info.arguments.size() + (info.takes_parts ? 1 : 0))
      Fail(node.Mark(), fmt::format("expected a map with the {} arguments of `{}`",
                                    info.arguments.size(), info.name));
    schema::Call call{std::string(info.name), {}};
    for (const schema::Parameter& argument : info.arguments)
      call.arguments.push_back(
          is_omitted(argument)
              ? schema::DefaultOf(argument)
              : ReadValue(Member(arguments, std::string(argument.name).c_str()), argument));
    if (!info.takes_parts) return call;
    const YAML::Node parts = Member(arguments, "parts");
    if (!parts.IsSequence() || parts.size() == 0)
      Fail(node.Mark(), fmt::format("`{}` needs a list of parts", info.name));
    for (const YAML::Node& part : parts)
      call.arguments.push_back(ReadValue(part, schema::PartParameter()));
    return call;
  }

  schema::Value ReadFormula(const YAML::Node& node, const schema::Parameter& parameter) const {
    if (node.size() > 1) Fail(node.Mark(), "expected a distribution or a word");
    if (parameter.type != schema::ParameterType::kReal ||
        (!parameter.distribution && !parameter.is_formula))
      Fail(node.Mark(), fmt::format("`{}` takes {}", parameter.name, parameter.Takes()));
    std::size_t parts = 0;
    schema::Value value = ReadPart(node.begin()->second, parameter, parts);
    if (schema::SettingsIn(value).empty())
      Fail(node.Mark(), parameter.is_formula ? "a formula must name a variable"
                                             : "a formula must name a drawn setting");
    return value;
  }

  schema::Value ReadPart(const YAML::Node& node, const schema::Parameter& parameter,
                         std::size_t& parts) const {
    if (++parts > schema::kMostFormulaParts)
      Fail(node.Mark(),
           fmt::format("a formula can have at most {} parts", schema::kMostFormulaParts));
    schema::Formula formula;
    if (!node.IsSequence() && parameter.is_formula) {
      if (!parameter.HasWord(Text(node))) return Real(node);
      formula.setting = Text(node);
      return formula;
    }
    if (!node.IsSequence()) {
      const schema::Parameter* named = schema::FindParameter(Text(node), true);
      if (named == nullptr) return Real(node);
      if (named->type != schema::ParameterType::kReal || !named->distribution)
        Fail(node.Mark(), fmt::format("`{}` is not a drawn number", named->name));
      formula.setting = named->name;
      return formula;
    }
    if (node.size() == 0 || !schema::IsFormulaOp(Text(node[0]), node.size() - 1))
      Fail(node.Mark(), "expected an operator or a function, and its arguments");
    formula.op = Text(node[0]);
    for (std::size_t i = 1; i < node.size(); ++i)
      formula.arguments.push_back(ReadPart(node[i], parameter, parts));
    return formula;
  }

  schema::Value ReadDistribution(const YAML::Node& node, const schema::Parameter& parameter) const {
    if (!parameter.distribution)
      Fail(node.Mark(), fmt::format("`{}` cannot be drawn", parameter.name));
    const std::string& name = Text(node.begin()->first);
    const auto kind = schema::FindDistribution(name);
    if (!kind) Fail(node.Mark(), fmt::format("this version has no distribution `{}`", name));
    schema::Distribution distribution{*kind, {}, {}};
    ReadArguments(node.begin()->second, parameter, distribution);
    const std::size_t wanted = schema::InfoOf(*kind).arguments;
    const bool enough =
        wanted == 0 ? !distribution.arguments.empty() : distribution.arguments.size() == wanted;
    const bool has_weights = distribution.weights.empty()
                                 ? *kind != schema::DistributionKind::kAny
                                 : distribution.weights.size() == distribution.arguments.size();
    if (!enough || !has_weights) Fail(node.Mark(), fmt::format("`{}` lacks arguments", name));
    ReadLimits(node, distribution);
    return distribution;
  }

  void ReadArguments(const YAML::Node& arguments, const schema::Parameter& parameter,
                     schema::Distribution& distribution) const {
    const bool is_any = distribution.kind == schema::DistributionKind::kAny;
    const bool has_weights = is_any || distribution.kind == schema::DistributionKind::kEmpirical;
    for (const YAML::Node& item : arguments) {
      if (is_any || (has_weights && item.IsSequence())) {
        if (!item.IsSequence() || item.size() != 2)
          Fail(item.Mark(), "expected a choice and its weight");
        distribution.arguments.push_back(ReadValue(item[0], parameter));
        if (schema::AsCall(distribution.arguments.back()) != nullptr && !parameter.ChoosesCalls())
          Fail(item.Mark(),
               fmt::format("a choice of `{}` cannot last for the whole run", parameter.name));
        distribution.weights.push_back(Real(item[1]));
        if (!(distribution.weights.back() > 0))
          Fail(item.Mark(), "a weight must be greater than 0");
      } else if (item.IsSequence()) {
        distribution.arguments.emplace_back(Vector(item));
      } else {
        distribution.arguments.emplace_back(Real(item));
      }
    }
  }

  void ReadLimits(const YAML::Node& node, schema::Distribution& distribution) const {
    for (const auto& entry : node) {
      const std::string& key = Text(entry.first);
      if (key == "in") {
        if (!entry.second.IsSequence() || entry.second.size() != 2)
          Fail(entry.second.Mark(), "expected two limits");
        distribution.limits = schema::Limits{Real(entry.second[0]), Real(entry.second[1])};
      } else if (key == "file") {
        distribution.file = Text(entry.second);
      } else if (key != schema::DistributionName(distribution.kind)) {
        Fail(entry.first.Mark(), fmt::format("a distribution has no `{}`", key));
      }
    }
  }

  [[noreturn]] void FailWord(const YAML::Node& node, const schema::Parameter& parameter) const {
    Fail(node.Mark(), fmt::format("`{}` takes {}", parameter.name, parameter.Takes()));
  }
};

class PlanReader : public ValueReader {
 public:
  using ValueReader::ValueReader;

  /// The key of the name of a group, or of a block of schema::kNamedBlocks.
  static std::string_view NameKey(std::string_view block) {
    return block == schema::kJointsBlock ? "joint" : block.empty() ? "name" : block;
  }

  /// Appends the settings as they are listed to `canonical`. `block`: of schema::kNamedBlocks, or
  /// empty.
  template <bool kGrouped>
  plan::SettingsOf<kGrouped> ReadSettings(const YAML::Node& map, std::string& canonical,
                                          std::span<const schema::PluginDetector> plugins = {},
                                          std::string_view block = {}) const {
    if (!map.IsMap()) Fail(map.Mark(), "expected a map of settings");
    plan::SettingsOf<kGrouped> settings;
    std::map<std::string_view, std::string> lines;
    for (const auto& entry : map) {
      const std::string& key = Text(entry.first);
      if (kGrouped && key == NameKey(block)) continue;
      const schema::Parameter* parameter = schema::FindParameter(key, kGrouped);
      if (parameter == nullptr || parameter->NamedBlock() != block)
        Fail(entry.first.Mark(), fmt::format("this version has no parameter `{}`", key));
      schema::Value value = ReadValue(entry.second, *parameter, plugins);
      lines[parameter->name] = plan::CanonicalLine(parameter->name, value);
      settings.SetValue(*parameter, std::move(value));
    }
    for (const schema::Parameter& parameter : schema::Schema())
      if (parameter.grouped == kGrouped && !settings.Has(parameter) &&
          plan::ValueIfAbsent(parameter) == nullptr)
        Fail(map.Mark(), fmt::format("`{}` is missing", parameter.name));
    for (const auto& [name, line] : lines) canonical += line;
    return settings;
  }

  /// A plan may be made by hand: what the engine takes for granted.
  void CheckJoint(const plan::Scene& scene, const plan::Joint& joint,
                  const YAML::Node& node) const {
    const auto fault = analysis::FindJointFault(scene, joint);
    if (!fault) return;
    const bool is_unknown = fault->kind == analysis::JointFault::Kind::kUnknownGroup;
    Fail(node.Mark(),
         is_unknown ? fmt::format("there is no group `{}`", fault->message) : fault->message);
  }

  /// `version`: of the plan.
  plan::Run ReadRun(const YAML::Node& node, int version = plan::kPlanVersion) const {
    plan::Run run;
    run.id = Text(Member(node, "id"));
    run.at = Indices(Member(node, "at"));
    run.rep = Count(Member(node, "rep"));
    if (node["role"]) run.scene.role = ReadRole(node["role"]);
    if (node["plugins"]) run.scene.plugins = ReadPlugins(node["plugins"]);
    std::string canonical;
    run.scene.world = ReadSettings<false>(Member(node, "world"), canonical, run.scene.plugins);
    canonical += plan::CanonicalLine(run.scene.role);
    for (const YAML::Node& group : Member(node, "groups")) {
      const std::string name = Name(Member(group, "name"));
      canonical += "group " + name + "\n";
      run.scene.groups.push_back({name, ReadSettings<true>(group, canonical)});
    }
    if (run.scene.groups.empty()) Fail(node.Mark(), "a run needs a group of objects");
    if (node["joints"]) {
      for (const YAML::Node& joint : node["joints"]) {
        const std::string name = Name(Member(joint, "joint"));
        canonical += "joint " + name + "\n";
        run.scene.joints.push_back(
            {name, ReadSettings<true>(joint, canonical, {}, schema::kJointsBlock)});
      }
      std::size_t next = 0;  // a joint may be in gear with a later one
      for (const YAML::Node& joint : node["joints"])
        CheckJoint(run.scene, run.scene.joints[next++], joint);
    }
    if (const auto fault = analysis::FindReducedFault(run.scene)) Fail(node.Mark(), fault->message);
    if (analysis::HasConfigurations(run.scene))
      if (const auto fault = analysis::FindConfigurationFault(run.scene))
        Fail(node.Mark(), fault->message);
    if (const auto fault = analysis::FindSoftFault(run.scene)) Fail(node.Mark(), fault->message);
    if (node["queries"])
      for (const YAML::Node& queries : node["queries"]) {
        const std::string name = Name(Member(queries, "queries"));
        canonical += "queries " + name + "\n";
        run.scene.queries.push_back(
            {name, ReadSettings<true>(queries, canonical, {}, schema::kQueriesBlock)});
        if (const auto fault = analysis::FindQueryFault(run.scene.queries.back()))
          Fail(queries.Mark(), fault->message);
      }
    if (const auto fault = analysis::FindPopulationFault(run.scene))
      Fail(node.Mark(), fault->message);
    if (analysis::Collisions(run.scene).ClassCount() > analysis::kMostCollisionClasses)
      Fail(node.Mark(), fmt::format("`collides_with` makes more than {} kinds of groups",
                                    analysis::kMostCollisionClasses));
    for (const auto& entry : Member(node, "seeds"))
      run.scene.seeds.emplace(Text(entry.first), Count(entry.second));
    for (const schema::PluginDetector& plugin : run.scene.plugins)
      if (!run.scene.Uses(plugin.name))
        Fail(node.Mark(), fmt::format("the run lists `{}` but does not use it", plugin.name));
    // In format 5, the id is a hash of everything that is listed.
    const std::string id =
        version == plan::kPlanVersion
            ? plan::RunId(run.scene, run.rep)
            : plan::RunIdOf(run.rep, canonical + plan::CanonicalTail(run.scene), version);
    if (run.id != id)
      Fail(node.Mark(), fmt::format("the run `{}` was changed by hand (its contents make `{}`); "
                                    "write the change into the .cdb file and plan again",
                                    run.id, id));
    return run;
  }

  std::vector<schema::PluginDetector> ReadPlugins(const YAML::Node& map) const {
    if (!map.IsMap()) Fail(map.Mark(), "expected a map of plug-in detectors");
    std::vector<schema::PluginDetector> plugins;
    for (const auto& entry : map) {
      schema::PluginDetector plugin;
      plugin.name = Name(entry.first);
      plugin.path = Text(Member(entry.second, "library"));
      plugin.sha256 = Text(Member(entry.second, "sha256"));
      plugin.phases = Text(Member(entry.second, "phases"));
      plugin.max_bodies = Count(Member(entry.second, "max_bodies"));
      if (std::ranges::find(schema::kPluginPhases, plugin.phases) ==
          std::end(schema::kPluginPhases))
        Fail(entry.second.Mark(), fmt::format("a detector has no phases `{}`", plugin.phases));
      if (schema::FindDetector(plugin.name, plugins))
        Fail(entry.first.Mark(), fmt::format("there are two detectors `{}`", plugin.name));
      plugins.push_back(std::move(plugin));
    }
    return plugins;
  }

  plan::Role ReadRole(const YAML::Node& node) const {
    for (const plan::Role role : {plan::Role::kReference, plan::Role::kTwin})
      if (Text(node) == plan::RoleName(role)) return role;
    Fail(node.Mark(), fmt::format("a run has no role `{}`", Text(node)));
  }

  plan::Axis ReadAxis(const YAML::Node& node) const {
    plan::Axis axis;
    axis.name = Name(Member(node, "name"));
    axis.parameter = Text(Member(node, "parameter"));
    axis.unit = Text(Member(node, "unit"));
    if (const YAML::Node title = node["title"]) axis.title = Text(title);
    const bool text = static_cast<bool>(node["labels"]);
    for (const YAML::Node& item : Member(node, text ? "labels" : "values")) {
      if (text) {
        axis.values.emplace_back(Text(item));
      } else {
        axis.values.emplace_back(Real(item));
      }
    }
    if (axis.values.empty()) Fail(node.Mark(), "an axis needs a value");
    for (const YAML::Node& item : node["sampled"]) {
      plan::Coordinates coordinates{Name(Member(item, "name")),
                                    Real(Member(item, "first")),
                                    Real(Member(item, "last")),
                                    Text(Member(item, "log")) == "true",
                                    {}};
      for (const YAML::Node& value : Member(item, "values"))
        coordinates.values.push_back(Real(value));
      if (coordinates.values.size() != axis.values.size())
        Fail(item.Mark(), fmt::format("`{}` has not one value for each point", coordinates.name));
      axis.sampled.push_back(std::move(coordinates));
    }
    if (const YAML::Node until = node["until"]) {
      if (text) Fail(node.Mark(), "a search needs an axis of numbers");
      axis.search = {ReadRequirement(until), Text(Member(node, "log")) == "true"};
    }
    if (const YAML::Node race = node["race"]) {
      const auto by = plan::FindFigure(Text(Member(race, "by")));
      if (!by || by->kind != plan::FigureKind::kTime)
        Fail(race.Mark(), "a race is by a time, such as mean(step)");
      axis.race = {*by, Real(Member(race, "tolerance"))};
    }
    return axis;
  }

  plan::Requirement ReadRequirement(const YAML::Node& node) const {
    const auto figure = plan::FindFigure(Text(Member(node, "figure")));
    const auto comparison = plan::FindComparison(Text(Member(node, "comparison")));
    if (!figure) Fail(node.Mark(), "there is no such figure");
    if (!comparison) Fail(node.Mark(), "there is no such comparison");
    return {Text(Member(node, "text")), *figure, *comparison, Real(Member(node, "limit"))};
  }

  plan::Plan ReadPlan(const YAML::Node& root) const {
    if (root.IsMap() && root[std::string(kShortPlanFormat)])
      throw PlanError(
          fmt::format("{}: this plan is in its short form, as it has {} runs; `cdb run` and `cdb "
                      "merge` take it, and other commands the .cdb file",
                      name_, Text(Member(root, "runs"))));
    if (!root.IsMap() || !root[std::string(kPlanFormat)])
      throw PlanError(
          fmt::format("{}: this is not a plan of cdb; `cdb plan FILE.cdb -o` writes one", name_));
    const std::uint64_t version = Count(root[std::string(kPlanFormat)]);
    CheckPlanVersion(version, plan::kOldestPlanVersion, name_);
    plan::Plan plan;
    plan.version = static_cast<int>(version);
    plan.benchmark = Name(Member(root, "benchmark"));
    plan.title = Text(Member(root, "title"));
    plan.source = Text(Member(root, "source"));
    plan.repeats = Count(Member(root, "repeats"));
    if (const YAML::Node budget = root["budget"]) plan.budget_s = Real(budget);
    if (const YAML::Node frame = root["frame"]) plan.frame_s = Real(frame);
    if (const YAML::Node requirements = root["requirements"])
      for (const YAML::Node& requirement : requirements)
        plan.requirements.push_back(ReadRequirement(requirement));
    for (const YAML::Node& axis : Member(root, "axes")) plan.axes.push_back(ReadAxis(axis));
    for (const YAML::Node& run : Member(root, "runs")) {
      plan.runs.push_back(ReadRun(run, plan.version));
      CheckPlace(run, plan, plan.runs.back().at);
      if (plan.runs.back().rep >= plan.repeats) Fail(run.Mark(), "`rep` is past `repeats`");
      if (plan.runs.back().scene.role != plan::Role::kMeasured)
        Fail(run.Mark(), "references are not runs of a plan; they follow from the runs");
      CheckAccuracy(run, plan.runs.back().scene);
    }
    for (const YAML::Node& point : Member(root, "skipped")) {
      plan.skipped.push_back(Indices(point));
      CheckPlace(point, plan, plan.skipped.back());
    }
    plan.scenario_text = Text(Member(root, "scenario"));
    analysis::AddReferences(plan);
    return plan;
  }

 private:
  /// Names become names of files, so only the characters that the language allows are accepted.
  std::string Name(const YAML::Node& node) const {
    const std::string& name = Text(node);
    if (!text::IsPlainName(name))
      Fail(node.Mark(), fmt::format("`{}` is not a name; a name consists of letters, digits and _, "
                                    "and does not begin with a digit",
                                    text::Printable(name)));
    return name;
  }

  /// Checks a property of compiled plans that the ids do not guarantee.
  void CheckAccuracy(const YAML::Node& node, const plan::Scene& scene) const {
    const analysis::AccuracyFault fault = analysis::FindAccuracyFault(scene);
    if (fault.parameter != nullptr) Fail(node.Mark(), fault.message);
  }

  void CheckPlace(const YAML::Node& node, const plan::Plan& plan,
                  const std::vector<std::size_t>& at) const {
    bool inside = at.size() == plan.axes.size();
    for (std::size_t i = 0; inside && i < at.size(); ++i)
      inside = at[i] < plan.axes[i].values.size();
    if (!inside) Fail(node.Mark(), "the indices are not on the axes");
  }
};

/// Parses and reads; errors of yaml-cpp become PlanErrors.
template <typename Read>
auto Parsed(const std::string& text, const std::string& name, Read read) {
  const PlanReader reader(name);
  // yaml-cpp accepts text that is not UTF-8 and changes it.
  for (std::size_t at = 0; at < text.size();) {
    const int bytes = text::DecodeUtf8(text, at).bytes;
    if (bytes == 0) throw PlanError(fmt::format("{}: byte {} is not UTF-8", name, at));
    at += static_cast<std::size_t>(bytes);
  }
  try {
    return read(reader, YAML::Load(text));
  } catch (const YAML::Exception& error) {
    reader.Fail(error.mark, error.msg);
  }
}

}  // namespace

plan::Run RunFromYaml(const std::string& text, const std::string& name) {
  return Parsed(text, name, [](const PlanReader& reader, const YAML::Node& root) {
    return reader.ReadRun(root);
  });
}

plan::Plan FromYaml(const std::string& text, const std::string& name) {
  return Parsed(text, name, [](const PlanReader& reader, const YAML::Node& root) {
    return reader.ReadPlan(root);
  });
}

}  // namespace cdb::yaml
