#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "compiler/plan/plan.h"
#include "compiler/yaml/plan_yaml.h"
#include "compiler/yaml/short_plan.h"
#include "dsl/text/utf8.h"

namespace cdb::yaml {

std::string ToYaml(const ShortPlan& plan) {
  YAML::Emitter out;
  out << YAML::Comment("A cdb plan in its short form: `cdb run` and `cdb merge` expand it.");
  out << YAML::BeginMap;
  out << YAML::Key << std::string(kShortPlanFormat) << YAML::Value << plan::kPlanVersion;
  const auto text = [&out](const char* key, const std::string& value) {
    out << YAML::Key << key << YAML::Value << YAML::DoubleQuoted << value;
  };
  text("benchmark", plan.benchmark);
  text("sha256", plan.sha256);
  out << YAML::Key << "runs" << YAML::Value << plan.runs;
  text("source", plan.source);
  text("file", plan.file);
  text("library", plan.library);
  out << YAML::Key << "plugins" << YAML::Value << YAML::Flow << YAML::BeginSeq;
  for (const std::string& plugin : plan.plugins) out << YAML::DoubleQuoted << plugin;
  out << YAML::EndSeq << YAML::Key << "files" << YAML::Value << YAML::BeginMap;
  for (const auto& [path, content] : plan.files)
    out << YAML::Key << YAML::DoubleQuoted << path << YAML::Value << YAML::DoubleQuoted << content;
  out << YAML::EndMap << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

void CheckPlanVersion(std::uint64_t version, int oldest, const std::string& name) {
  if (version < static_cast<std::uint64_t>(oldest) || version > plan::kPlanVersion)
    throw PlanError(fmt::format(
        "{}: a plan of format {}, but this cdb reads format {}; plan again from the .cdb file",
        name, version, plan::kPlanVersion));
}

std::optional<ShortPlan> FindShortPlan(const std::string& text, const std::string& name) {
  // A plan that lists its runs may be large, so it is not parsed for this check.
  const std::string key = fmt::format("\n{}:", kShortPlanFormat);
  if (text.substr(0, 400).find(key) == std::string::npos) return std::nullopt;
  try {
    const YAML::Node root = YAML::Load(text);
    // Its hash is of the plan that is compiled from it, in the same format.
    CheckPlanVersion(root[std::string(kShortPlanFormat)].as<std::uint64_t>(), plan::kPlanVersion,
                     name);
    ShortPlan plan;
    plan.benchmark = root["benchmark"].as<std::string>();
    if (!text::IsPlainName(plan.benchmark))
      throw PlanError(
          fmt::format("{}:{}: `{}` is not a name; a name consists of letters, digits and _, and "
                      "does not begin with a digit",
                      name, root["benchmark"].Mark().line + 1, text::Printable(plan.benchmark)));
    plan.sha256 = root["sha256"].as<std::string>();
    plan.runs = root["runs"].as<std::uint64_t>();
    plan.source = root["source"].as<std::string>();
    plan.file = root["file"].as<std::string>();
    plan.library = root["library"].as<std::string>();
    plan.plugins = root["plugins"].as<std::vector<std::string>>();
    plan.files = root["files"].as<std::map<std::string, std::string>>();
    return plan;
  } catch (const YAML::Exception& error) {
    throw PlanError(
        fmt::format("{}:{}: {}; the short form of a plan is damaged: plan again from "
                    "the .cdb file",
                    name, error.mark.line + 1, error.msg));
  }
}

}  // namespace cdb::yaml
