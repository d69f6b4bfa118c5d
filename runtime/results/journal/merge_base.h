// The results file from which a merge takes the runs that no journal holds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/results/hdf5/file.h"
#include "runtime/results/layout.h"

namespace cdb::journal {

/// Values are passed on as stored, with filtered chunks. Cells are numbered in grid order. Throws
/// StoreError, hdf5::Error. Not thread-safe.
class MergeBase {
 public:
  enum class Of { kSamePlan, kAnyPlan };
  /// Throws StoreError for a file of another plan, unless that is allowed, or of another schema
  /// version. `facts` must outlive it.
  MergeBase(const std::filesystem::path& path, const results::PlanFacts& facts,
            Of of = Of::kSamePlan);

  const hdf5::File& file() const { return file_; }
  /// True if the cell holds a run, not only a place for one.
  bool Has(std::size_t cell) const;
  /// In the order of facts.numbers and facts.texts.
  double Number(std::size_t index, std::size_t cell) const { return numbers_[index][cell]; }
  const std::string& Text(std::size_t index, std::size_t cell) const { return texts_[index][cell]; }
  /// Facts about build and machine of a run, by name.
  std::map<std::string, std::string> ProvenanceOf(const std::string& run_id) const;

  /// First row and number of rows of the contacts of a cell; nullopt if none were recorded.
  struct Rows {
    std::uint64_t first, count;
  };
  std::optional<Rows> ContactRows(std::size_t cell) const;

 private:
  void ReadProvenance();

  hdf5::File file_;
  std::vector<std::vector<double>> numbers_;
  std::vector<std::vector<std::string>> texts_;
  std::vector<double> contact_first_;
  std::uint64_t contact_rows_ = 0;
  std::map<std::string, std::string> shared_;  ///< facts that all runs have
  std::map<std::string, std::size_t> places_;  ///< index of a run's id in the texts of varied_
  std::map<std::string, std::vector<std::string>> varied_;
};

}  // namespace cdb::journal
