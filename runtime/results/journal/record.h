// The record of a finished run: its facts, and its arrays in chunks as the results file will hold
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/results/hdf5/object.h"
#include "runtime/results/store.h"

namespace cdb::journal {

/// An array of which a record holds chunks.
struct RecordedArray {
  std::string name;  ///< as in results::Layout
  hdf5::Type type = hdf5::Type::kFloat64;
  hdf5::Shape shape, chunk;  ///< within a cell of the grid; empty: one chunk, of any length
  bool operator==(const RecordedArray&) const = default;
};

/// What the records of many runs have in common. Names stand here, so that a merge finds its arrays
/// and facts in records of other versions of cdb.
struct About {
  std::vector<RecordedArray> arrays;
  std::vector<std::string> numbers, texts;  ///< names of the facts of a run
  results::Provenance provenance;           ///< text attributes of /provenance

  std::vector<std::byte> Encode() const;
  /// Throws hdf5::Error for bytes that Encode did not make.
  static About Decode(std::span<const std::byte> bytes);
};

struct Record {
  struct Chunk {
    std::uint32_t array = 0;  ///< index in About::arrays
    std::uint32_t index = 0;  ///< index within the cell
    std::uint64_t bytes = 0;
    bool operator==(const Chunk&) const = default;
  };

  std::string run_id;
  std::shared_ptr<const About> about;
  std::vector<double> numbers;     ///< in the order of About::numbers, as HDF5 stores them
  std::vector<std::string> texts;  ///< in the order of About::texts
  std::vector<Chunk> chunks;
  std::vector<std::byte> bytes;  ///< of all chunks, filtered, one after the other

  /// Facts and list of chunks; not `bytes`.
  std::vector<std::byte> EncodeFacts() const;
  /// `about`, `bytes` and the id are set. Throws hdf5::Error for facts that do not match them.
  void DecodeFacts(std::span<const std::byte> facts);

  /// Nullopt if there is no such fact.
  std::optional<double> Number(std::string_view name) const;
  std::string Text(std::string_view name) const;  ///< empty if there is none
  void Add(std::uint32_t array, std::uint32_t index, std::span<const std::byte> filtered);
};

/// What is asked about a run without its arrays.
struct RunInfo {
  std::string run_id;
  results::Outcome outcome;
  std::string omitted, decisions;  ///< as in RunResult
  bool is_noisy = false;
};
/// Throws hdf5::Error for an unknown status or verdict.
RunInfo InfoOf(const Record& record);

}  // namespace cdb::journal
