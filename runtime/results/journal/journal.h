// A journal: the finished runs of a sweep, and what was asked of the sweep, in an SQLite file.
// README.md describes it. Only journal.cc uses SQLite.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "runtime/results/files/errors.h"
#include "runtime/results/journal/record.h"

namespace cdb::journal {

inline constexpr std::string_view kEnding = ".journal";

/// SQLite cannot read a journal, or it is none: `path` holds nothing that can be used as it stands.
class DamagedJournal : public files::StoreError {
 public:
  DamagedJournal(std::filesystem::path path, const std::string& why);
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The record of a run is not as it was written. Other runs of the journal are not affected.
class DamagedRun : public files::StoreError {
 public:
  DamagedRun(const std::filesystem::path& path, const std::string& run_id, std::string_view why);
  const std::string& run_id() const { return run_id_; }

 private:
  std::string run_id_;
};

/// True if the file begins as a journal does. Must not be called for a file that this process has
/// open as a Journal: closing any descriptor of a file gives up the locks that SQLite has on it.
bool IsJournal(const std::filesystem::path& path);

/// The name of the journal that this process writes in `folder`. On a local disk, all processes
/// share one file. On a network file system, each process has a file of its own, and locks nothing.
std::filesystem::path OwnJournal(const std::filesystem::path& folder);

/// An open journal of one plan. Not thread-safe. A process must not use it after a fork, and must
/// not have two of them open for the same file on a network file system.
///
/// All members throw StoreError if the file cannot be read or written, DamagedJournal if SQLite
/// finds it damaged. An error changes nothing.
class Journal {
 public:
  /// Opens OwnJournal(folder), and creates it for the plan if it does not exist.
  static Journal OpenToWrite(const std::filesystem::path& folder, const std::string& plan_sha256);
  /// Does not change the file, and does not wait for a process that writes it.
  static Journal OpenToRead(const std::filesystem::path& file);
  Journal(Journal&&) noexcept;
  Journal& operator=(Journal&&) noexcept;
  ~Journal();

  const std::filesystem::path& path() const;
  /// Empty if the process that creates the file has not written anything yet.
  const std::string& plan_sha256() const;

  /// Throws StoreError if the file has been removed or replaced since it was opened for writing.
  void RequireInPlace() const;

  /// Writes a run, in place of an earlier one with the same id. When it returns, the run is on the
  /// disk. Throws StoreError also if the file was removed meanwhile, or holds another plan now.
  void Write(const Record& record) { Write(std::span(&record, 1)); }
  /// The same for several runs, in one step.
  void Write(std::span<const Record> records);
  /// Removes the run from the file, and the marks of parts, which would hide that it is missing.
  void Forget(const std::string& run_id);
  /// Removes all runs and requests, and starts over for the plan. `asked` is the first request, if
  /// not empty; its value is the plan. All in one step.
  void Restart(const std::string& plan_sha256, const std::string& asked);

  bool Has(const std::string& run_id);
  /// Nullopt if it is not there. Throws DamagedRun.
  std::optional<Record> Read(const std::string& run_id);
  /// The run in a row that ForEachRun has named; nullopt if it was removed or rewritten meanwhile.
  /// Throws DamagedRun.
  std::optional<Record> ReadRow(std::int64_t row);

  /// Rows are in the order in which they were written; a later one has a higher number.
  struct Row {
    std::int64_t number = 0;
    std::string run_id;
    std::int64_t written_ns = 0;  ///< since 1970, by the clock of the machine that wrote it
  };
  using VisitRow = std::function<void(const Row&)>;
  /// Calls `visit` for the rows after number `after`; backwards from the last one if `reversed`.
  void ForEachRun(const VisitRow& visit, std::int64_t after = 0, bool reversed = false);
  std::uint64_t CountRuns();

  /// Requests, by name: `fresh`, `retry`, `submission`, and marks of finished parts.
  struct Request {
    std::string value;
    std::int64_t written_ns = 0;
  };
  std::map<std::string, Request> Requests();
  void Ask(const std::string& what, const std::string& value);

  /// What SQLite finds wrong in the structure of the file; empty if nothing. Reads all of it.
  std::string FindFault();

 private:
  struct Impl;
  explicit Journal(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cdb::journal
