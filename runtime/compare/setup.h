// What two results files were made by: machine, build, parameters (`cdb compare`). Said before any
// figure.
#pragma once

#include <string>
#include <vector>

#include "runtime/compare/match.h"

namespace cdb::compare {

/// A fact that differs, as each file has it; `-` for none.
struct SetupDifference {
  std::string name;
  std::string a, b;
};

struct SetupComparison {
  std::vector<SetupDifference> machine;     ///< machine, build and versions
  std::vector<SetupDifference> parameters;  ///< of the runs, and plug-ins
  std::vector<std::string> notes;           ///< sentences about builds and occasions to be wary of
  bool is_interleaved = false;              ///< the runs of both files, in time
};
/// Compares the provenance of two files, and the scenes of their matched points. Throws StoreError
/// if parameters that make another scene differ, with what to do.
SetupComparison CompareSetups(const ComparedFile& a, const ComparedFile& b,
                              const PointMatch& match);

}  // namespace cdb::compare
