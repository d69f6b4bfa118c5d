// Differences in machine, build and parameters between two results files (`cdb compare`), printed
// before any figure.
#pragma once

#include <string>
#include <vector>

#include "runtime/compare/match.h"

namespace cdb::compare {

/// A fact that differs, with its value in each file; `-` if it has none.
struct SetupDifference {
  std::string name;
  std::string a, b;
};

struct SetupComparison {
  std::vector<SetupDifference> machine;     ///< machine, build and versions
  std::vector<SetupDifference> parameters;  ///< parameters of the runs, and plug-ins
  std::vector<std::string> notes;           ///< warnings about builds and occasions, in sentences
  bool is_interleaved = false;              ///< the runs of both files are interleaved in time
};
/// Compares the provenance of two files, and the scenes of their matched points. Throws StoreError,
/// with the remedy, if parameters of the scene differ.
SetupComparison CompareSetups(const ComparedFile& a, const ComparedFile& b,
                              const PointMatch& match);

}  // namespace cdb::compare
