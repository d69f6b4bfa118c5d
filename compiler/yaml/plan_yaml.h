// The plan as a YAML document: what `cdb plan -o` writes and a worker reads.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "compiler/plan/plan.h"

namespace cdb::yaml {

/// The key of the format's version, by which a plan is known.
inline constexpr std::string_view kPlanFormat = "cdb_plan";

/// A document that is no plan: the message names the file, the line, what is wrong and what to do.
class PlanError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reading back gives an equal plan: reals are written so that they round-trip, seeds in
/// hexadecimal.
std::string ToYaml(const plan::Plan& plan);

/// `name` is for messages. Throws PlanError for a document of another version, a wrong type, an
/// unknown parameter, or a run whose id is not that of its contents.
plan::Plan FromYaml(const std::string& text, const std::string& name);

/// One run alone, as a worker gets it. Same form as an entry of the plan's `runs`.
std::string RunToYaml(const plan::Run& run);
plan::Run RunFromYaml(const std::string& text, const std::string& name);

}  // namespace cdb::yaml
