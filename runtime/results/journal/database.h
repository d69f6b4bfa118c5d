// A connection to the SQLite file of a journal. Nothing else uses SQLite.
#pragma once

#include <sqlite3.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace cdb::journal {

using Bytes = std::span<const std::byte>;

inline constexpr std::uintmax_t kPageBytes = 4096;
/// s; another process has the write lock for the time of a commit or of a checkpoint.
inline constexpr int kPatience = 60;

/// The file with another ending, as SQLite names its log.
std::filesystem::path Beside(const std::filesystem::path& path, std::string_view ending);
bool HasBytes(const std::filesystem::path& path);

/// Not thread-safe. All members throw StoreError if the file cannot be read or written,
/// DamagedJournal if SQLite finds it damaged.
class Database {
 public:
  /// Does not open it.
  explicit Database(std::filesystem::path at) : path(std::move(at)) {}
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  ~Database();

  /// Throws StoreError if the path leads to something other than a file, or, if it must exist, to
  /// nothing. Does not open it: see IsJournal.
  void RequireFile(bool must_exist) const;

  /// Creates the file if it does not exist. On a network file system, nobody else may write it.
  void OpenToWrite(bool is_local);
  void OpenToRead();
  /// Requires that nobody writes it: takes no locks, and ignores the log.
  void OpenUnchanging();
  /// Opens a copy of the file in a folder of its own, in which SQLite may undo an unfinished
  /// commit.
  void OpenCopy();

  /// The open file: `path`, or its copy.
  std::filesystem::path OpenedFile() const { return copy_ ? copy_->file() : path; }

  void Do(const char* sql);
  std::int64_t NumberOf(const char* sql);
  std::int64_t LastRow() const { return sqlite3_last_insert_rowid(db_); }

  /// A statement that is prepared once, and reset when this is destroyed.
  class Statement {
   public:
    Statement(Database& database, const char* sql);
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    Statement& Bind(std::int64_t number);
    /// The text or the bytes must outlive the statement.
    Statement& Bind(const std::string& text);
    Statement& Bind(Bytes bytes);
    /// True if there is a row.
    bool Step(std::string_view doing = "read it");
    std::int64_t Number(int column) const { return sqlite3_column_int64(statement_, column); }
    std::string Text(int column) const;
    Bytes BytesAt(int column) const;

   private:
    Database& database_;
    sqlite3_stmt* statement_;
    int bound_ = 0;
  };

  /// One commit; nothing is changed if it is destroyed before.
  class Transaction {
   public:
    explicit Transaction(Database& database);
    ~Transaction();
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;
    void Commit() { Statement(database_, "COMMIT").Step("write it"); }

   private:
    Database& database_;
  };

  const std::filesystem::path path;

 private:
  class Copy {
   public:
    explicit Copy(const std::filesystem::path& path);
    ~Copy();
    Copy(const Copy&) = delete;
    Copy& operator=(const Copy&) = delete;
    std::filesystem::path file() const { return folder_ / "copy"; }

   private:
    std::filesystem::path folder_;
  };

  void Open(const std::filesystem::path& file, std::string_view query, int flags,
            const char* system = nullptr);
  void Close();
  int SystemError() const;
  [[noreturn]] void Fail(std::string_view doing) const;

  std::optional<Copy> copy_;  // removed after the file is closed
  sqlite3* db_ = nullptr;
  std::map<std::string_view, sqlite3_stmt*> statements_;
};

}  // namespace cdb::journal
