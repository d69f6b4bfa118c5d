// The plan as a YAML document: the output of `cdb plan -o` and the input of a worker.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "compiler/plan/plan.h"

namespace cdb::yaml {

/// The key of the format version, which identifies a plan.
inline constexpr std::string_view kPlanFormat = "cdb_plan";

/// The document is not a plan: the message gives file, line, error and remedy.
class PlanError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Only what differs from the defaults (plan::Settings). Reading the text back gives an equal plan:
/// reals are written so that they round-trip, seeds in hexadecimal.
std::string ToYaml(const plan::Plan& plan);

/// `name` is for messages. Formats from kOldestPlanVersion are read, and their ids kept
/// (Plan::Renew). Throws PlanError for a document of another one, a wrong type, an unknown
/// parameter, or a run whose id does not match its contents.
plan::Plan FromYaml(const std::string& text, const std::string& name);

/// The format of a plan, in either form, without reading all of it; nullopt for other texts.
std::optional<int> FindPlanVersion(std::string_view yaml);

/// A single run, as passed to a worker. Same form as an entry of the plan's `runs`.
std::string RunToYaml(const plan::Run& run);
plan::Run RunFromYaml(const std::string& text, const std::string& name);

}  // namespace cdb::yaml
