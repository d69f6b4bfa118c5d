#include "compiler/yaml/plan_yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "compiler/analysis/reference.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"

namespace cdb::yaml {
namespace {

/// Reals as YAML: never mistaken for another type, and the same double when read back.
std::string YamlReal(double value) { return schema::FormatReal(value); }

struct WriteValue {
  YAML::Emitter& out;

  void operator()(bool on) const { out << (on ? "on" : "off"); }
  void operator()(const schema::Number& number) const { out << number.Text(); }
  void operator()(const schema::Word& word) const { out << word.text; }
  void operator()(const Eigen::Vector3d& v) const { WriteReals(v); }
  void operator()(const schema::Ratio& ratio) const { WriteReals(ratio.parts); }
  void operator()(const schema::WordList& words) const {
    out << YAML::Flow << YAML::BeginSeq;
    for (const std::string& word : words) out << word;
    out << YAML::EndSeq;
  }
  void operator()(const schema::Text& text) const { out << YAML::DoubleQuoted << text.text; }
  void operator()(const schema::Call& call) const {
    const schema::ParametrisedWord& info = *schema::FindParametrisedWord(call.name);
    out << YAML::Flow << YAML::BeginMap << YAML::Key << call.name << YAML::Value;
    if (schema::ListsPoints(call)) {
      out << YAML::BeginSeq;
      for (const schema::Value& point : call.arguments) Write(point);
      out << YAML::EndSeq << YAML::EndMap;
      return;
    }
    out << YAML::BeginMap;
    for (std::size_t i = 0; i < info.arguments.size(); ++i) {
      const schema::Parameter& argument = info.arguments[i];
      if (argument.omitted_at_default &&
          schema::ToText(call.arguments[i]) == argument.DefaultText())
        continue;
      out << YAML::Key << std::string(argument.name) << YAML::Value;
      Write(call.arguments[i]);
    }
    if (info.takes_parts) {
      out << YAML::Key << "parts" << YAML::Value << YAML::BeginSeq;
      for (const schema::Value& part : schema::PartsOf(call)) Write(part);
      out << YAML::EndSeq;
    }
    out << YAML::EndMap << YAML::EndMap;
  }
  void operator()(const schema::Distribution& d) const {
    out << YAML::Flow << YAML::BeginMap << YAML::Key
        << std::string(schema::DistributionName(d.kind)) << YAML::Value << YAML::BeginSeq;
    for (std::size_t i = 0; i < d.arguments.size(); ++i) {
      if (d.weights.empty()) {
        Write(d.arguments[i]);
        continue;
      }
      out << YAML::BeginSeq;
      Write(d.arguments[i]);
      out << YamlReal(d.weights[i]) << YAML::EndSeq;
    }
    out << YAML::EndSeq;
    if (d.limits)
      out << YAML::Key << "in" << YAML::Value << YAML::BeginSeq << YamlReal(d.limits->least)
          << YamlReal(d.limits->most) << YAML::EndSeq;
    if (!d.file.empty()) out << YAML::Key << "file" << YAML::Value << YAML::DoubleQuoted << d.file;
    out << YAML::EndMap;
  }

  void operator()(const schema::Formula& formula) const {
    out << YAML::Flow << YAML::BeginMap << YAML::Key << "formula" << YAML::Value;
    WriteFormula(formula);
    out << YAML::EndMap;
  }

  /// `["*", 2, ["^", size, 3]]`: an operator before its arguments; a name, or a number.
  void WriteFormula(const schema::Value& part) const {
    const schema::Formula* formula = schema::AsFormula(part);
    if (formula == nullptr) return Write(part);
    if (formula->op.empty()) {
      out << formula->setting;
      return;
    }
    out << YAML::Flow << YAML::BeginSeq << YAML::DoubleQuoted << formula->op;
    for (const schema::Value& argument : formula->arguments) WriteFormula(argument);
    out << YAML::EndSeq;
  }

  void Write(const schema::Value& value) const {
    std::visit(*this, static_cast<const schema::Value::variant&>(value));
  }
  void WriteReals(const Eigen::Vector3d& v) const {
    out << YAML::Flow << YAML::BeginSeq << YamlReal(v.x()) << YamlReal(v.y()) << YamlReal(v.z())
        << YAML::EndSeq;
  }
};

void WritePlugins(YAML::Emitter& out, const std::vector<schema::PluginDetector>& plugins) {
  out << YAML::Key << "plugins" << YAML::Value << YAML::BeginMap;
  for (const schema::PluginDetector& plugin : plugins) {
    out << YAML::Key << plugin.name << YAML::Value << YAML::BeginMap;
    out << YAML::Key << "library" << YAML::Value << YAML::DoubleQuoted << plugin.path;
    out << YAML::Key << "sha256" << YAML::Value << YAML::DoubleQuoted << plugin.sha256;
    out << YAML::Key << "phases" << YAML::Value << plugin.phases;
    out << YAML::Key << "max_bodies" << YAML::Value << plugin.max_bodies << YAML::EndMap;
  }
  out << YAML::EndMap;
}

void WriteRequirement(YAML::Emitter& out, const plan::Requirement& of) {
  out << YAML::BeginMap << YAML::Key << "text" << YAML::Value << YAML::DoubleQuoted << of.text
      << YAML::Key << "figure" << YAML::Value << YAML::DoubleQuoted << of.figure.Text() << YAML::Key
      << "comparison" << YAML::Value << YAML::DoubleQuoted
      << std::string(plan::ComparisonText(of.comparison)) << YAML::Key << "limit" << YAML::Value
      << YamlReal(of.limit) << YAML::EndMap;
}

void WriteRequirements(YAML::Emitter& out, const std::vector<plan::Requirement>& requirements) {
  out << YAML::Key << "requirements" << YAML::Value << YAML::BeginSeq;
  for (const plan::Requirement& of : requirements) WriteRequirement(out, of);
  out << YAML::EndSeq;
}

void WriteAxis(YAML::Emitter& out, const plan::Axis& axis) {
  out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << axis.name;
  out << YAML::Key << "parameter" << YAML::Value << YAML::DoubleQuoted << axis.parameter;
  out << YAML::Key << "unit" << YAML::Value << YAML::DoubleQuoted << axis.unit;
  if (!axis.title.empty())
    out << YAML::Key << "title" << YAML::Value << YAML::DoubleQuoted << axis.title;
  out << YAML::Key << (axis.IsText() ? "labels" : "values") << YAML::Value << YAML::Flow
      << YAML::BeginSeq;
  for (const plan::Coordinate& value : axis.values) {
    if (const auto* number = std::get_if<double>(&value)) {
      out << YamlReal(*number);
    } else {
      out << YAML::DoubleQuoted << std::get<std::string>(value);
    }
  }
  out << YAML::EndSeq;
  if (!axis.sampled.empty()) out << YAML::Key << "sampled" << YAML::Value << YAML::BeginSeq;
  for (const plan::Coordinates& coordinates : axis.sampled) {
    out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << coordinates.name;
    out << YAML::Key << "first" << YAML::Value << YamlReal(coordinates.first);
    out << YAML::Key << "last" << YAML::Value << YamlReal(coordinates.last);
    out << YAML::Key << "log" << YAML::Value << coordinates.is_log;
    out << YAML::Key << "values" << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (const double value : coordinates.values) out << YamlReal(value);
    out << YAML::EndSeq << YAML::EndMap;
  }
  if (!axis.sampled.empty()) out << YAML::EndSeq;
  if (axis.search) {
    out << YAML::Key << "until" << YAML::Value;
    WriteRequirement(out, axis.search->until);
    out << YAML::Key << "log" << YAML::Value << axis.search->is_log;
  }
  if (axis.race) {
    out << YAML::Key << "race" << YAML::Value << YAML::BeginMap;
    out << YAML::Key << "by" << YAML::Value << axis.race->by.Text();
    out << YAML::Key << "tolerance" << YAML::Value << YamlReal(axis.race->tolerance);
    out << YAML::EndMap;
  }
  out << YAML::EndMap;
}

/// Appends each line of `text` after `indent`.
void AppendIndented(std::string_view text, std::string_view indent, std::string& out) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    out += indent;
    out += text.substr(0, end);
    text.remove_prefix(end);
  }
}

std::string SettingYaml(std::string_view name, const schema::Value& value) {
  // The same text as from the emitter, which is slow for numbers.
  if (const schema::Number* number = schema::AsNumber(value))
    return fmt::format("{}: {}\n", name, number->Text());
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << std::string(name) << YAML::Value;
  WriteValue{out}.Write(value);
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

std::string Indices(const std::vector<std::size_t>& at) {
  return fmt::format("[{}]", fmt::join(at, ", "));
}

/// Size at which the text is passed on as a piece, in bytes.
constexpr std::size_t kPiece = 1 << 16;

}  // namespace

bool RunText::Update(const plan::Settings& settings, std::string_view indent, Lines& lines) const {
  bool is_changed = false;
  std::size_t i = 0;
  for (const auto& [name, value] : settings) {
    if (i == lines.size()) lines.emplace_back();
    Line& line = lines[i++];
    if (line.name == name && schema::IsIdentical(line.value, value) && !line.yaml.empty()) continue;
    const std::string yaml = SettingYaml(name, value);
    line = {std::string(name), value, plan::CanonicalLine(name, value), {}};
    AppendIndented(yaml, indent_ + std::string(indent), line.yaml);
    is_changed = true;
  }
  is_changed = is_changed || lines.size() != i;
  lines.resize(i);
  return is_changed;
}

bool RunText::UpdateAll(const auto& groups, const char* key, std::vector<GroupLines>& lines) const {
  bool is_changed = lines.size() != groups.size();
  lines.resize(groups.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    is_changed = Update(groups[i].settings, "    ", lines[i].lines) || is_changed;
    if (lines[i].name == groups[i].name) continue;
    is_changed = true;
    YAML::Emitter out;
    out << YAML::BeginMap << YAML::Key << key << YAML::Value << groups[i].name << YAML::EndMap;
    lines[i].name = groups[i].name;
    lines[i].yaml = indent_ + "  - " + out.c_str() + "\n";
  }
  return is_changed;
}

void RunText::Append(std::string_view kind, const std::vector<GroupLines>& groups) {
  for (const GroupLines& group : groups) {
    canonical_ += fmt::format("{} {}\n", kind, group.name);
    yaml_ += group.yaml;
    for (const Line& line : group.lines) {
      canonical_ += line.canonical;
      yaml_ += line.yaml;
    }
  }
}

void RunText::Set(const plan::Scene& scene) {
  bool is_changed = !std::exchange(is_begun_, true);
  is_changed = Update(scene.world, "  ", world_) || is_changed;
  is_changed = UpdateAll(scene.groups, "name", groups_) || is_changed;
  is_changed = UpdateAll(scene.joints, "joint", joints_) || is_changed;
  is_changed = UpdateAll(scene.queries, "queries", queries_) || is_changed;
  if (!is_changed && role_ == scene.role && seeds_ == scene.seeds && plugins_ == scene.plugins)
    return;
  role_ = scene.role;
  seeds_ = scene.seeds;
  plugins_ = scene.plugins;
  Join(scene);
}

void RunText::Join(const plan::Scene& scene) {
  canonical_.clear();
  yaml_.clear();
  const auto add = [this](std::string_view line) { AppendIndented(line, indent_, yaml_); };
  if (role_ != plan::Role::kMeasured) add(fmt::format("role: {}\n", plan::RoleName(role_)));
  add(world_.empty() ? "world:\n  {}\n" : "world:\n");
  for (const Line& line : world_) {
    canonical_ += line.canonical;
    yaml_ += line.yaml;
  }
  canonical_ += plan::CanonicalLine(role_);
  add("groups:\n");
  Append("group", groups_);
  if (!joints_.empty()) add("joints:\n");
  Append("joint", joints_);
  if (!queries_.empty()) add("queries:\n");
  Append("queries", queries_);
  add(seeds_.empty() ? "seeds:\n  {}\n" : "seeds:\n");
  for (const auto& [stream, seed] : seeds_) add(fmt::format("  {}: {:#018x}\n", stream, seed));
  canonical_ += plan::CanonicalTail(scene);
  if (plugins_.empty()) return;
  YAML::Emitter out;
  out << YAML::BeginMap;
  WritePlugins(out, plugins_);
  out << YAML::EndMap;
  add(std::string(out.c_str()) + "\n");
}

std::string RunText::Id(std::uint64_t rep) const { return plan::RunIdOf(rep, canonical_); }

std::string RunText::AppendYaml(const std::vector<std::size_t>& at, std::uint64_t rep,
                                std::string& out) const {
  std::string id = Id(rep);
  out += fmt::format("id: \"{}\"\n{}at: {}\n{}rep: {}\n", id, indent_, Indices(at), indent_, rep);
  out += yaml_;
  return id;
}

std::string RunText::YamlOf(const plan::Run& run) {
  Set(run.scene);
  std::string out;
  AppendYaml(run.at, run.rep, out);
  return out;
}

PlanWriter::PlanWriter(const plan::Plan& head, std::function<void(std::string_view)> write)
    : head_(head), write_(std::move(write)) {
  YAML::Emitter out;
  out << YAML::Comment(
      "A cdb plan: every run of a benchmark, with the settings that differ from their defaults. "
      "`cdb run` executes it as it is.");
  out << YAML::BeginMap;
  out << YAML::Key << std::string(kPlanFormat) << YAML::Value << plan::kPlanVersion;
  out << YAML::Key << "benchmark" << YAML::Value << YAML::DoubleQuoted << head.benchmark;
  out << YAML::Key << "title" << YAML::Value << YAML::DoubleQuoted << head.title;
  out << YAML::Key << "source" << YAML::Value << YAML::DoubleQuoted << head.source;
  out << YAML::Key << "repeats" << YAML::Value << head.repeats;
  if (head.budget_s) out << YAML::Key << "budget" << YAML::Value << YamlReal(*head.budget_s);
  if (head.frame_s) out << YAML::Key << "frame" << YAML::Value << YamlReal(*head.frame_s);
  if (!head.requirements.empty()) WriteRequirements(out, head.requirements);
  out << YAML::Key << "axes" << YAML::Value << YAML::BeginSeq;
  for (const plan::Axis& axis : head.axes) WriteAxis(out, axis);
  out << YAML::EndSeq << YAML::EndMap;
  buffer_ = std::string(out.c_str()) + "\nskipped:\n";
}

void PlanWriter::Flush(std::size_t more_than) {
  if (buffer_.size() <= more_than) return;
  write_(buffer_);
  buffer_.clear();
}

void PlanWriter::AddSkipped(const std::vector<std::size_t>& at) {
  has_skipped_ = true;
  buffer_ += "  - " + Indices(at) + "\n";
  Flush(kPiece);
}

void PlanWriter::BeginRuns() {
  if (!std::exchange(has_runs_, true)) buffer_ += has_skipped_ ? "runs:\n" : "  []\nruns:\n";
}

std::string PlanWriter::AddRun(const std::vector<std::size_t>& at, std::uint64_t rep,
                               const plan::Scene& scene) {
  BeginRuns();
  text_.Set(scene);
  buffer_ += "  - ";
  std::string id = text_.AppendYaml(at, rep, buffer_);
  Flush(kPiece);
  return id;
}

void PlanWriter::Finish() {
  if (!has_runs_) buffer_ += has_skipped_ ? "runs:\n  []\n" : "  []\nruns:\n  []\n";
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "scenario" << YAML::Value << YAML::DoubleQuoted
      << head_.scenario_text << YAML::EndMap;
  buffer_ += std::string(out.c_str()) + "\n";
  Flush(0);
}

std::string RunToYaml(const plan::Run& run) { return RunText("").YamlOf(run); }

std::string ToYaml(const plan::Plan& plan) {
  std::string text;
  PlanWriter writer(plan, [&](std::string_view piece) { text += piece; });
  for (const auto& point : plan.skipped) writer.AddSkipped(point);
  for (const plan::Run& run : plan.runs) writer.AddRun(run.at, run.rep, run.scene);
  writer.Finish();
  return text;
}

namespace {

using DerivedScenes = unsigned;
constexpr DerivedScenes kRest = schema::Parameter::kPile;
constexpr DerivedScenes kFall = schema::Parameter::kPile | schema::Parameter::kDrop;

bool IsIgnored(const schema::Parameter& parameter, DerivedScenes by) {
  return (parameter.ignored_by & by) != 0;
}

void EraseIgnored(bool grouped, DerivedScenes by, plan::Settings& settings) {
  for (const schema::Parameter& parameter : schema::Schema())
    if (parameter.grouped == grouped && IsIgnored(parameter, by)) settings.EraseValue(parameter);
}

plan::Scene QuietScene(const plan::Scene& scene, DerivedScenes ignored) {
  plan::Scene quiet = scene;
  quiet.role = plan::Role::kMeasured;
  quiet.DropQueries();
  EraseIgnored(false, ignored, quiet.world);
  quiet.world.Set("omit", schema::WordList{"none"});
  quiet.world.Set("record", schema::WordList{});
  quiet.world.Set("sleeping", false);
  quiet.KeepUsedPlugins();
  return quiet;
}

/// `pile`: DropScene or RestScene of the scene.
std::string TextOf(plan::Scene pile, DerivedScenes ignored) {
  for (plan::Group& group : pile.groups) {
    if (!HasPile(group)) continue;
    EraseIgnored(true, ignored, group.settings);
    for (const schema::Parameter& parameter : schema::Schema())
      if (parameter.grouped && IsIgnored(parameter, ignored))
        pile.seeds.erase(group.name + "." + std::string(parameter.name));
  }
  // Of a twin, whose objects are moved after the pile has settled.
  pile.seeds.erase("nudge");
  plan::Run run;
  run.scene = std::move(pile);
  return RunToYaml(run);
}

}  // namespace

bool HasPile(const plan::Group& group) {
  const schema::Call* layout = schema::AsCall(group.settings.Get("location"));
  return layout != nullptr && layout->name == "pile" && group.settings.Count("quantity") > 0;
}

bool HasPile(const plan::Scene& scene) {
  return std::ranges::any_of(scene.groups, [](const plan::Group& group) { return HasPile(group); });
}

bool SharesPile(const plan::Scene& scene) {
  return scene.role != plan::Role::kMeasured || analysis::NeedsReference(scene);
}

plan::Scene DropScene(const plan::Scene& scene) {
  plan::Scene drop = QuietScene(scene, kFall);
  drop.world.Set("precision", schema::Word{"double"});
  return drop;
}

plan::Scene RestScene(const plan::Scene& scene) {
  plan::Scene rest = QuietScene(scene, kRest);
  if (!SharesPile(scene)) return rest;
  for (const schema::Parameter& parameter : schema::Schema())
    if (!parameter.of_reference.empty())
      rest.world.EraseValue(*schema::FindParameter(parameter.of_reference, false));
  rest.world.Set("precision", schema::Word{"double"});
  return rest;
}

std::string DropText(const plan::Scene& scene) { return TextOf(DropScene(scene), kFall); }

std::string PileText(const plan::Scene& scene) {
  return TextOf(RestScene(scene), kRest) + (SharesPile(scene) ? "shared\n" : "");
}

}  // namespace cdb::yaml
