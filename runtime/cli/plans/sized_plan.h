// Plans of any size, for the commands that execute or merge them. Plans that are too long to be
// listed are kept as grids.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/grid/grid.h"
#include "compiler/plan/plan.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"

namespace cdb::plans {

struct SizedPlan {
  /// Either lists all runs, or has a `whole` and lists none.
  plan::Plan plan;
  std::shared_ptr<const grid::Grid> grid;  ///< null if the plan lists its runs
  /// The plan in its short form: the texts that it is compiled from, as YAML, which is read in a
  /// tenth of the time. Empty if the plan was read from a list of runs.
  std::string short_text = {};

  /// For a plan that lists no runs: part `index`, from 0, of `count` (compiler/grid/part.h).
  plan::Plan ListPart(std::uint64_t index, std::uint64_t count) const;
};

/// The plans of a `.cdb` file, or of a plan as YAML in either form, as by LoadPlans. Throws
/// CommandError also for a long plan whose runs are compared with reference runs, and for a plan in
/// the short form that this version expands to another plan.
std::vector<SizedPlan> LoadSizedPlans(const std::string& file,
                                      const std::optional<std::string>& benchmark,
                                      options::LintText lints,
                                      const std::vector<std::string>& plugins);

/// The plan in `text`, the contents of the plan file `name`.
SizedPlan ReadSizedPlan(const std::string& text, const std::string& name);

/// The plan file in the folder of a sweep, in its short form if there is one; empty if there is
/// none.
std::string FindPlanIn(const std::filesystem::path& folder);
/// The plan in `text`, the contents of `file` as named by FindPlanIn. If this cdb, or its plug-ins,
/// expand a short form to another plan, the list of runs beside it is read instead.
SizedPlan ReadPlanFile(const std::string& file, const std::string& text);

/// Prints the summary of results that this process has merged or opened: their values have been
/// proven then. Exit status 3 if a run did not end well.
options::ExitStatus ShowResult(const std::filesystem::path& out, bool is_quiet);

}  // namespace cdb::plans
