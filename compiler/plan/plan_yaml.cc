#include "compiler/plan/plan_yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <string>
#include <variant>
#include <vector>

#include "compiler/schema/parametrised_words.h"

namespace cdb::plan {
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
    for (std::size_t i = 0; i < call.arguments.size(); ++i) {
      out << YAML::Key << std::string(info.arguments[i].name) << YAML::Value;
      Write(call.arguments[i]);
    }
    out << YAML::EndMap << YAML::EndMap;
  }
  void operator()(const schema::Distribution& d) const {
    out << YAML::Flow << YAML::BeginMap << YAML::Key
        << std::string(schema::DistributionName(d.kind)) << YAML::Value << YAML::BeginSeq;
    for (std::size_t i = 0; i < d.arguments.size(); ++i) {
      if (d.kind != schema::DistributionKind::kAny) {
        Write(d.arguments[i]);
        continue;
      }
      out << YAML::BeginSeq;
      Write(d.arguments[i]);
      out << YamlReal(d.weights[i]) << YAML::EndSeq;
    }
    out << YAML::EndSeq << YAML::EndMap;
  }

  void Write(const schema::Value& value) const {
    std::visit(*this, static_cast<const schema::Value::variant&>(value));
  }
  void WriteReals(const Eigen::Vector3d& v) const {
    out << YAML::Flow << YAML::BeginSeq << YamlReal(v.x()) << YamlReal(v.y()) << YamlReal(v.z())
        << YAML::EndSeq;
  }
};

void WriteSettings(YAML::Emitter& out, const Settings& settings) {
  for (const auto& [name, value] : settings) {
    if (IsLeftOutOfPlans(name, value)) continue;
    out << YAML::Key << name << YAML::Value;
    WriteValue{out}.Write(value);
  }
}

void WriteIndices(YAML::Emitter& out, const std::vector<std::size_t>& at) {
  out << YAML::Flow << YAML::BeginSeq;
  for (const std::size_t index : at) out << index;
  out << YAML::EndSeq;
}

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

void WriteRun(YAML::Emitter& out, const Run& run) {
  out << YAML::BeginMap;
  out << YAML::Key << "id" << YAML::Value << YAML::DoubleQuoted << run.id;
  out << YAML::Key << "at" << YAML::Value;
  WriteIndices(out, run.at);
  out << YAML::Key << "rep" << YAML::Value << run.rep;
  if (run.scene.role != Role::kMeasured)
    out << YAML::Key << "role" << YAML::Value << std::string(RoleName(run.scene.role));
  out << YAML::Key << "world" << YAML::Value << YAML::BeginMap;
  WriteSettings(out, run.scene.world);
  out << YAML::EndMap << YAML::Key << "groups" << YAML::Value << YAML::BeginSeq;
  for (const Group& group : run.scene.groups) {
    out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << group.name;
    WriteSettings(out, group.settings);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::Key << "seeds" << YAML::Value << YAML::BeginMap;
  for (const auto& [stream, seed] : run.scene.seeds)
    out << YAML::Key << stream << YAML::Value << fmt::format("{:#018x}", seed);
  out << YAML::EndMap;
  if (!run.scene.plugins.empty()) WritePlugins(out, run.scene.plugins);
  out << YAML::EndMap;
}

void WriteAxis(YAML::Emitter& out, const Axis& axis) {
  out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << axis.name;
  out << YAML::Key << "parameter" << YAML::Value << YAML::DoubleQuoted << axis.parameter;
  out << YAML::Key << "unit" << YAML::Value << YAML::DoubleQuoted << axis.unit;
  out << YAML::Key << (axis.IsText() ? "labels" : "values") << YAML::Value << YAML::Flow
      << YAML::BeginSeq;
  for (const Coordinate& value : axis.values) {
    if (const auto* number = std::get_if<double>(&value)) {
      out << YamlReal(*number);
    } else {
      out << YAML::DoubleQuoted << std::get<std::string>(value);
    }
  }
  out << YAML::EndSeq << YAML::EndMap;
}

}  // namespace

std::string RunToYaml(const Run& run) {
  YAML::Emitter out;
  WriteRun(out, run);
  return std::string(out.c_str()) + "\n";
}

std::string ToYaml(const Plan& plan) {
  YAML::Emitter out;
  out << YAML::Comment("A cdb plan: every run of a benchmark. `cdb run` executes it as it is.");
  out << YAML::BeginMap;
  out << YAML::Key << std::string(kPlanFormat) << YAML::Value << kPlanVersion;
  out << YAML::Key << "benchmark" << YAML::Value << YAML::DoubleQuoted << plan.benchmark;
  out << YAML::Key << "title" << YAML::Value << YAML::DoubleQuoted << plan.title;
  out << YAML::Key << "source" << YAML::Value << YAML::DoubleQuoted << plan.source;
  out << YAML::Key << "repeats" << YAML::Value << plan.repeats;
  out << YAML::Key << "axes" << YAML::Value << YAML::BeginSeq;
  for (const Axis& axis : plan.axes) WriteAxis(out, axis);
  out << YAML::EndSeq << YAML::Key << "skipped" << YAML::Value << YAML::BeginSeq;
  for (const auto& point : plan.skipped) WriteIndices(out, point);
  out << YAML::EndSeq << YAML::Key << "runs" << YAML::Value << YAML::BeginSeq;
  for (const Run& run : plan.runs) WriteRun(out, run);
  out << YAML::EndSeq;
  out << YAML::Key << "scenario" << YAML::Value << YAML::DoubleQuoted << plan.scenario_text;
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

}  // namespace cdb::plan
