// `/provenance` of a merged file: facts about build and machine. A fact that is the same in every
// run is an attribute; others are arrays over `run`, the ids of the runs.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/results/hdf5/file.h"
#include "runtime/results/store.h"

namespace cdb::results {

/// The dimension of the arrays in the group.
inline constexpr std::string_view kProvenanceRuns = "run";

class MergedProvenance {
 public:
  /// The facts of one run, by name.
  void Add(const std::string& run_id, const std::map<std::string, std::string>& facts);
  /// Creates the group. `of_merging`: facts of this process, used if no run has them.
  hdf5::Group Write(hdf5::File& file, const Provenance& of_merging) const;

 private:
  /// The distinct texts of one fact, and the index of each run's text.
  struct Fact {
    std::vector<std::string> texts = {""};  ///< the first is for runs without the fact
    std::vector<std::size_t> by_run;        ///< in the order of ids_; runs at the end may be
                                            ///< missing
    std::map<std::string, std::size_t> places = {{"", 0}};
  };

  std::vector<std::string> TextsOf(const Fact& fact) const;

  std::vector<std::string> ids_;
  std::map<std::string, Fact> facts_;
};

}  // namespace cdb::results
