#include "runtime/results/journal/journal.h"

#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "runtime/protocol/machine/machine.h"
#include "runtime/results/files/local_disk.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/files/seal.h"

namespace cdb::journal {
namespace {

namespace fs = std::filesystem;
using Bytes = std::span<const std::byte>;

/// In the head of the file, at byte 68: `cdbj`.
constexpr std::uint32_t kApplication = 0x6364626a;
constexpr int kVersion = 1;
constexpr std::string_view kMagic("SQLite format 3\0", 16);
/// s; another process has the write lock for the time of a commit or of a checkpoint.
constexpr int kPatience = 60;
/// SQLite's limit of a value is 1 GB.
constexpr std::size_t kMostBytes = 500'000'000;

constexpr std::uintmax_t kPageBytes = 4096;
constexpr const char* kSettings =
    "PRAGMA page_size = 4096; PRAGMA temp_store = MEMORY; PRAGMA cell_size_check = ON;"
    "PRAGMA secure_delete = OFF; PRAGMA trusted_schema = OFF; PRAGMA synchronous = FULL;";
constexpr const char* kOwnFile = "PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = TRUNCATE;";
constexpr const char* kSharedFile = "PRAGMA journal_mode = WAL;";
constexpr const char* kTables =
    "CREATE TABLE asked(what TEXT PRIMARY KEY, value TEXT NOT NULL, written INTEGER NOT NULL);"
    "CREATE TABLE about(number INTEGER PRIMARY KEY, bytes BLOB NOT NULL);"
    "CREATE TABLE run(number INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE, written INTEGER NOT "
    "NULL,"
    " about INTEGER NOT NULL, checksum INTEGER NOT NULL, facts BLOB NOT NULL, chunks BLOB NOT "
    "NULL);"
    "CREATE TABLE more(run INTEGER, place INTEGER, bytes BLOB NOT NULL, PRIMARY KEY(run, place));";

std::int64_t Now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// For SQLite, which takes a URI: `file:` and the path.
std::string UriOf(const fs::path& path, std::string_view query) {
  std::string uri = "file:";
  for (const char c : path.string())
    if (c == '%' || c == '?' || c == '#')
      uri += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    else
      uri += c;
  return uri.append(query);
}

fs::path Beside(const fs::path& path, std::string_view ending) {
  return path.string() + std::string(ending);
}

bool HasBytes(const fs::path& path) {
  std::error_code error;
  const auto bytes = fs::file_size(path, error);
  return !error && bytes > 0;
}

std::uint64_t ChecksumOfRun(const std::string& id, std::int64_t written, std::uint64_t about,
                            Bytes facts, Bytes chunks) {
  const std::array<std::uint64_t, 5> parts = {files::Checksum(std::as_bytes(std::span(id))),
                                              static_cast<std::uint64_t>(written), about,
                                              files::Checksum(facts), files::Checksum(chunks)};
  return files::Checksum(std::as_bytes(std::span(parts)));
}

/// Waits until no commit is under way in a file on a network file system. False if one is
/// unfinished: its process was killed.
bool IsSettled(const fs::path& path) {
  for (int tries = 0; HasBytes(Beside(path, "-journal")); ++tries) {
    if (tries == 100) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

}  // namespace

DamagedJournal::DamagedJournal(fs::path path, const std::string& why)
    : StoreError(fmt::format("{}: is not a whole journal: {}; it was left as it is: `cdb run` sets "
                             "it aside and runs again what cannot be read",
                             path.string(), why)),
      path_(std::move(path)) {}

DamagedRun::DamagedRun(const fs::path& path, const std::string& run_id, std::string_view why)
    : StoreError(fmt::format("{}: its run {} is damaged: {}; it was left as it is: `cdb run` runs "
                             "it again",
                             path.string(), run_id, why)),
      run_id_(run_id) {}

bool IsJournal(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::array<char, 72> head = {};
  std::ifstream(path, std::ios::binary).read(head.data(), head.size());
  std::uint32_t application = 0;
  for (int i = 68; i < 72; ++i)
    application = application << 8 | static_cast<unsigned char>(head[static_cast<std::size_t>(i)]);
  return std::string_view(head.data(), kMagic.size()) == kMagic && application == kApplication;
}

fs::path OwnJournal(const fs::path& folder) {
  if (files::IsOnLocalDisk(folder)) return folder / ("runs" + std::string(kEnding));
  static const std::uint64_t mine = std::random_device()();
  return folder / fmt::format("runs.{}.{}.{:08x}{}", machine::HostName(), getpid(), mine, kEnding);
}

struct Journal::Impl {
  /// A copy of a journal in a folder of its own, in which SQLite may undo an unfinished commit.
  class Copy {
   public:
    explicit Copy(const fs::path& path) {
      std::string name = (fs::temp_directory_path() / "cdb-journal-XXXXXX").string();
      if (mkdtemp(name.data()) == nullptr)
        throw files::StoreError(
            fmt::format("{}: cannot be copied to be read: {}; nothing was changed", path.string(),
                        std::strerror(errno)));
      folder_ = name;
      std::error_code error;
      fs::copy_file(path, file(), error);
      if (!error) fs::copy_file(Beside(path, "-journal"), Beside(file(), "-journal"), error);
      if (!error) return;
      fs::remove_all(folder_);
      throw files::StoreError(
          fmt::format("{}: cannot be copied to be read: {}; nothing was changed", path.string(),
                      error.message()));
    }
    ~Copy() {
      std::error_code ignored;
      fs::remove_all(folder_, ignored);
    }
    Copy(const Copy&) = delete;
    Copy& operator=(const Copy&) = delete;
    fs::path file() const { return folder_ / "copy"; }

   private:
    fs::path folder_;
  };

  /// A row of `about`.
  struct Shared {
    std::int64_t number = 0;
    std::uint64_t checksum = 0;
    std::shared_ptr<const About> about;
  };

  explicit Impl(fs::path at) : path(std::move(at)) {}
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() { Close(); }

  void Close() {
    for (const auto& [sql, statement] : statements) sqlite3_finalize(statement);
    statements.clear();
    sqlite3_close(std::exchange(db, nullptr));
  }

  void Open(const std::string& uri, int flags, const char* system = nullptr) {
    Close();
    const int code =
        sqlite3_open_v2(uri.c_str(), &db, flags | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, system);
    sqlite3_extended_result_codes(db, 1);
    if (code != SQLITE_OK) Fail("open it");
    sqlite3_busy_timeout(db, 1000 * kPatience);
    sqlite3_db_config(db, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    Do(kSettings);
  }

  /// Does not open it: see IsJournal.
  void RequireFile(bool must_exist) const {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (fs::is_regular_file(status) || (!must_exist && !fs::exists(status))) return;
    const std::string why = !fs::exists(status)        ? std::generic_category().message(ENOENT)
                            : fs::is_directory(status) ? "it is a folder, not a file"
                            : fs::is_fifo(status)      ? "it is a pipe, not a file"
                                                       : "it is a device, not a file";
    throw files::StoreError(
        fmt::format("{}: cannot be read: {}; nothing was changed", path.string(), why));
  }

  /// The error number of the last call of the system that failed; 0 if it is unknown.
  int SystemError() const {
    for (const int which : {SQLITE_FCNTL_JOURNAL_POINTER, SQLITE_FCNTL_FILE_POINTER}) {
      sqlite3_file* file = nullptr;
      int error = 0;
      if (sqlite3_file_control(db, "main", which, &file) == SQLITE_OK && file != nullptr &&
          file->pMethods != nullptr &&
          file->pMethods->xFileControl(file, SQLITE_FCNTL_LAST_ERRNO, &error) == SQLITE_OK &&
          error != 0)
        return error;
    }
    return sqlite3_system_errno(db);
  }

  [[noreturn]] void Fail(std::string_view doing) const {
    const std::string said = sqlite3_errmsg(db);
    int error = 0;
    switch (sqlite3_errcode(db) & 0xff) {
      // The statements are correct, so that the tables are not: they are not as they were made.
      case SQLITE_CORRUPT:
      case SQLITE_NOTADB:
      case SQLITE_ERROR:
      case SQLITE_CONSTRAINT:
      case SQLITE_MISMATCH:
      case SQLITE_TOOBIG:
        throw DamagedJournal(path, said);
      case SQLITE_FULL:
        error = ENOSPC;
        break;
      case SQLITE_READONLY:
        error = EROFS;
        break;
      case SQLITE_IOERR:
        error = SystemError();
        break;
      case SQLITE_CANTOPEN:
        // SQLite tries to open a file for reading if it cannot write it, and reports that.
        error = access(path.parent_path().c_str(), W_OK) != 0 ? errno : sqlite3_system_errno(db);
        break;
      default:
        break;
    }
    throw files::StoreError(fmt::format(
        "{}: cannot {}: {}; nothing that was finished is lost: {}", path.string(), doing,
        error != 0 ? std::generic_category().message(error) : said, files::WriteRemedy(error)));
  }

  void Do(const char* sql) {
    if (sqlite3_exec(db, sql, nullptr, nullptr, nullptr) != SQLITE_OK) Fail("use it");
  }

  /// A statement that is prepared once, and reset when this is destroyed.
  class Statement {
   public:
    Statement(Impl& impl, const char* sql) : impl_(impl) {
      sqlite3_stmt*& prepared = impl.statements[sql];
      if (prepared == nullptr && sqlite3_prepare_v3(impl.db, sql, -1, SQLITE_PREPARE_PERSISTENT,
                                                    &prepared, nullptr) != SQLITE_OK)
        impl.Fail("read it");
      statement_ = prepared;
    }
    ~Statement() {
      sqlite3_reset(statement_);
      sqlite3_clear_bindings(statement_);
    }
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    Statement& Bind(std::int64_t number) {
      sqlite3_bind_int64(statement_, ++bound_, number);
      return *this;
    }
    /// The text or the bytes must outlive the statement.
    Statement& Bind(const std::string& text) {
      sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_STATIC,
                          SQLITE_UTF8);
      return *this;
    }
    Statement& Bind(Bytes bytes) {
      if (bytes.empty())
        sqlite3_bind_zeroblob(statement_, ++bound_, 0);
      else
        sqlite3_bind_blob64(statement_, ++bound_, bytes.data(), bytes.size(), SQLITE_STATIC);
      return *this;
    }
    /// True if there is a row.
    bool Step(std::string_view doing = "read it") {
      const int code = sqlite3_step(statement_);
      if (code != SQLITE_ROW && code != SQLITE_DONE) impl_.Fail(doing);
      return code == SQLITE_ROW;
    }
    std::int64_t Number(int column) const { return sqlite3_column_int64(statement_, column); }
    std::string Text(int column) const {
      const auto bytes = BytesAt(column);
      return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    Bytes BytesAt(int column) const {
      const void* data = sqlite3_column_blob(statement_, column);
      return {static_cast<const std::byte*>(data),
              static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
    }

   private:
    Impl& impl_;
    sqlite3_stmt* statement_;
    int bound_ = 0;
  };

  std::int64_t NumberOf(const char* sql) {
    Statement statement(*this, sql);
    return statement.Step() ? statement.Number(0) : 0;
  }

  /// One commit; nothing is changed if it is destroyed before.
  class Transaction {
   public:
    explicit Transaction(Impl& impl) : impl_(impl) {
      Statement(impl_, "BEGIN IMMEDIATE").Step("write it");
    }
    ~Transaction() {
      if (sqlite3_get_autocommit(impl_.db) == 0)
        sqlite3_exec(impl_.db, "ROLLBACK", nullptr, nullptr, nullptr);
    }
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;
    void Commit() { Statement(impl_, "COMMIT").Step("write it"); }

   private:
    Impl& impl_;
  };

  std::string PlanInFile() {
    Statement statement(*this, "SELECT value FROM asked WHERE what = 'plan'");
    return statement.Step() ? statement.Text(0) : std::string();
  }

  /// False if the file has no tables yet.
  bool CheckHead() {
    const std::int64_t version = NumberOf("PRAGMA user_version");
    if (version == 0 && NumberOf("SELECT count(*) FROM sqlite_schema") == 0) {
      // SQLite takes a file without a whole page for an empty one.
      std::error_code error;
      if (const auto bytes = fs::file_size(path, error); !error && bytes % kPageBytes != 0)
        throw DamagedJournal(path, "it is cut short");
      return false;
    }
    if (NumberOf("PRAGMA application_id") != kApplication)
      throw DamagedJournal(path, "it is an SQLite file of another program");
    if (version != kVersion)
      throw files::StoreError(fmt::format(
          "{}: is a journal of version {}, and this cdb uses version {}; it was left as "
          "it is: end the sweep with the cdb that began it, or start over with --fresh",
          path.string(), version, kVersion));
    // SQLite reads what is missing of the last page as zeros. A log may hold the last pages.
    const fs::path file = copy ? copy->file() : path;
    const auto bytes = static_cast<std::uintmax_t>(NumberOf("PRAGMA page_count")) * kPageBytes;
    std::error_code error;
    if (!HasBytes(Beside(file, "-wal")) && fs::file_size(file, error) < bytes)
      throw DamagedJournal(path, "it is cut short");
    return true;
  }

  void Create(const std::string& for_plan) {
    Transaction transaction(*this);
    if (CheckHead()) return;
    Do(kTables);
    Do(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplication, kVersion)
           .c_str());
    AskNow("plan", for_plan);
    transaction.Commit();
  }

  void AskNow(const std::string& what, const std::string& value) {
    Statement(*this, "INSERT OR REPLACE INTO asked VALUES(?, ?, ?)")
        .Bind(what)
        .Bind(value)
        .Bind(Now_ns())
        .Step("write it");
  }

  void RequireInPlace() const {
    struct stat now = {};
    if (stat(path.c_str(), &now) != 0 || now.st_ino != inode)
      throw files::StoreError(
          fmt::format("{}: was removed while the runs went; nothing was merged", path.string()));
  }

  /// Before a commit: the path still leads to this file, and the file is still of this plan.
  void CheckIsOurs() {
    RequireInPlace();
    if (PlanInFile() != plan)
      throw files::StoreError(fmt::format(
          "{}: another cdb has started over in it with another plan (--fresh); this one stops",
          path.string()));
  }

  /// The row of `about`; written now if this process has not written it yet.
  const Shared& SharedOf(const std::shared_ptr<const About>& about, std::optional<Shared>& added) {
    const auto known = std::ranges::find(written, about, &Shared::about);
    if (known != written.end()) return *known;
    const std::vector<std::byte> bytes = about->Encode();
    Statement(*this, "INSERT INTO about(bytes) VALUES(?)").Bind(Bytes(bytes)).Step("write it");
    added = {sqlite3_last_insert_rowid(db), files::Checksum(bytes), about};
    return *added;
  }

  const Shared& SharedAt(std::int64_t number, const std::string& run_id) {
    const auto known = read.find(number);
    if (known != read.end()) return known->second;
    Statement statement(*this, "SELECT bytes FROM about WHERE number = ?");
    if (!statement.Bind(number).Step()) throw DamagedRun(path, run_id, "its head is missing");
    const Bytes bytes = statement.BytesAt(0);
    try {
      constexpr std::size_t kMost = 1000;
      if (read.size() >= kMost) read.clear();
      const Shared shared = {number, files::Checksum(bytes),
                             std::make_shared<const About>(About::Decode(bytes))};
      return read.emplace(number, shared).first->second;
    } catch (const hdf5::Error& error) {
      throw DamagedRun(path, run_id, error.what());
    }
  }

  /// `found` is at a row: number, id, written, about, checksum, facts, chunks.
  Record RecordAt(const Statement& found) {
    Record record;
    record.run_id = found.Text(1);
    const Shared shared = SharedAt(found.Number(3), record.run_id);
    record.about = shared.about;
    const Bytes facts = found.BytesAt(5), chunks = found.BytesAt(6);
    record.bytes.assign(chunks.begin(), chunks.end());
    if (record.bytes.size() >= kMostBytes) {
      Statement more(*this, "SELECT bytes FROM more WHERE run = ? ORDER BY place");
      more.Bind(found.Number(0));
      while (more.Step()) {
        const Bytes next = more.BytesAt(0);
        record.bytes.insert(record.bytes.end(), next.begin(), next.end());
      }
    }
    if (ChecksumOfRun(record.run_id, found.Number(2), shared.checksum, facts, record.bytes) !=
        static_cast<std::uint64_t>(found.Number(4)))
      throw DamagedRun(path, record.run_id, "its checksum differs");
    try {
      record.DecodeFacts(facts);
    } catch (const hdf5::Error& error) {
      throw DamagedRun(path, record.run_id, error.what());
    }
    return record;
  }

  fs::path path;
  std::optional<Copy> copy;  // removed after the file is closed
  sqlite3* db = nullptr;
  std::string plan;
  ino_t inode = 0;
  std::map<std::string_view, sqlite3_stmt*> statements;
  std::vector<Shared> written;
  std::map<std::int64_t, Shared> read;  // by number
};

Journal::Journal(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Journal::Journal(Journal&&) noexcept = default;
Journal& Journal::operator=(Journal&&) noexcept = default;
Journal::~Journal() = default;

const fs::path& Journal::path() const { return impl_->path; }
const std::string& Journal::plan_sha256() const { return impl_->plan; }

Journal Journal::OpenToWrite(const fs::path& folder, const std::string& plan_sha256) {
  files::RequireFolder(folder, "finished runs");
  auto impl = std::make_unique<Impl>(OwnJournal(folder));
  impl->RequireFile(/*must_exist=*/false);
  const bool is_local = files::IsOnLocalDisk(folder);
  impl->Open(UriOf(impl->path, ""), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE,
             is_local ? nullptr : "unix-none");
  // SQLite does not wait for a lock when it changes the mode.
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(kPatience);
  while (sqlite3_exec(impl->db, is_local ? kSharedFile : kOwnFile, nullptr, nullptr, nullptr) !=
         SQLITE_OK) {
    if ((sqlite3_errcode(impl->db) & 0xff) != SQLITE_BUSY || std::chrono::steady_clock::now() > end)
      impl->Fail("write it");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  impl->Create(plan_sha256);
  impl->plan = impl->PlanInFile();
  struct stat status = {};
  if (stat(impl->path.c_str(), &status) == 0) impl->inode = status.st_ino;
  return Journal(std::move(impl));
}

Journal Journal::OpenToRead(const fs::path& file) {
  auto impl = std::make_unique<Impl>(file);
  impl->RequireFile(/*must_exist=*/true);
  bool has_tables = false;
  if (!files::IsOnLocalDisk(file)) {
    if (IsSettled(file)) {
      impl->Open(UriOf(file, "?immutable=1"), SQLITE_OPEN_READONLY);
    } else {
      impl->copy.emplace(file);
      impl->Open(UriOf(impl->copy->file(), ""), SQLITE_OPEN_READWRITE, "unix-none");
    }
    has_tables = impl->CheckHead();
  } else {
    try {
      // A connection that may not write would leave the files beside the journal behind.
      impl->Open(UriOf(file, ""), SQLITE_OPEN_READWRITE);
      impl->Do("PRAGMA query_only = ON");
      has_tables = impl->CheckHead();
    } catch (const DamagedJournal&) {
      throw;
    } catch (const files::StoreError&) {
      // On a full disk, or where this process may not write, there is no place for what readers
      // share. Without a log, the file can be read as it stands.
      if (HasBytes(Beside(file, "-wal"))) throw;
      impl->Open(UriOf(file, "?immutable=1"), SQLITE_OPEN_READONLY);
      has_tables = impl->CheckHead();
    }
  }
  if (has_tables) impl->plan = impl->PlanInFile();
  return Journal(std::move(impl));
}

void Journal::RequireInPlace() const { impl_->RequireInPlace(); }

void Journal::Write(const Record& record) {
  const std::int64_t now = Now_ns();
  const std::vector<std::byte> facts = record.EncodeFacts();
  const Bytes bytes(record.bytes);
  std::optional<Impl::Shared> added;
  {
    Impl::Transaction transaction(*impl_);
    impl_->CheckIsOurs();
    const Impl::Shared& shared = impl_->SharedOf(record.about, added);
    Impl::Statement(*impl_, "DELETE FROM more WHERE run = (SELECT number FROM run WHERE id = ?)")
        .Bind(record.run_id)
        .Step("write it");
    const std::uint64_t checksum = ChecksumOfRun(record.run_id, now, shared.checksum, facts, bytes);
    Impl::Statement(*impl_,
                    "INSERT OR REPLACE INTO run(id, written, about, checksum, facts, chunks) "
                    "VALUES(?, ?, ?, ?, ?, ?)")
        .Bind(record.run_id)
        .Bind(now)
        .Bind(shared.number)
        .Bind(static_cast<std::int64_t>(checksum))
        .Bind(Bytes(facts))
        .Bind(bytes.first(std::min(bytes.size(), kMostBytes)))
        .Step("write it");
    const std::int64_t row = sqlite3_last_insert_rowid(impl_->db);
    for (std::size_t at = kMostBytes; at < bytes.size(); at += kMostBytes)
      Impl::Statement(*impl_, "INSERT INTO more VALUES(?, ?, ?)")
          .Bind(row)
          .Bind(static_cast<std::int64_t>(at))
          .Bind(bytes.subspan(at, std::min(bytes.size() - at, kMostBytes)))
          .Step("write it");
    transaction.Commit();
  }
  if (added) impl_->written.push_back(*std::move(added));
}

void Journal::Forget(const std::string& run_id) {
  Impl::Transaction transaction(*impl_);
  Impl::Statement(*impl_, "DELETE FROM run WHERE id = ?").Bind(run_id).Step("write it");
  Impl::Statement(*impl_, "DELETE FROM asked WHERE what LIKE 'part %'").Step("write it");
  transaction.Commit();
}

void Journal::Restart(const std::string& plan_sha256, const std::string& asked) {
  Impl::Transaction transaction(*impl_);
  // Rows of `about` stay: another process may be using their numbers.
  for (const char* sql : {"DELETE FROM run", "DELETE FROM more", "DELETE FROM asked"})
    Impl::Statement(*impl_, sql).Step("write it");
  impl_->AskNow("plan", plan_sha256);
  if (!asked.empty()) impl_->AskNow(asked, plan_sha256);
  transaction.Commit();
  impl_->plan = plan_sha256;
}

bool Journal::Has(const std::string& run_id) {
  if (impl_->plan.empty()) return false;
  return Impl::Statement(*impl_, "SELECT 1 FROM run WHERE id = ?").Bind(run_id).Step();
}

std::optional<Record> Journal::Read(const std::string& run_id) {
  if (impl_->plan.empty()) return std::nullopt;
  Impl::Statement found(*impl_,
                        "SELECT number, id, written, about, checksum, facts, chunks FROM run "
                        "WHERE id = ?");
  if (!found.Bind(run_id).Step()) return std::nullopt;
  Record record = impl_->RecordAt(found);
  if (record.run_id != run_id) throw DamagedRun(impl_->path, run_id, "its place holds another run");
  return record;
}

std::optional<Record> Journal::ReadRow(std::int64_t row) {
  Impl::Statement found(*impl_,
                        "SELECT number, id, written, about, checksum, facts, chunks FROM run "
                        "WHERE number = ?");
  if (!found.Bind(row).Step()) return std::nullopt;
  return impl_->RecordAt(found);
}

void Journal::ForEachRun(const VisitRow& visit, std::int64_t after, bool reversed) {
  if (impl_->plan.empty()) return;
  // From the table, and not from the index of ids: a row is found though its index is damaged.
  Impl::Statement rows(
      *impl_, reversed ? "SELECT number, id, written FROM run WHERE number > ? ORDER BY number DESC"
                       : "SELECT number, id, written FROM run WHERE number > ? ORDER BY number");
  rows.Bind(after);
  while (rows.Step()) visit({rows.Number(0), rows.Text(1), rows.Number(2)});
}

std::uint64_t Journal::CountRuns() {
  if (impl_->plan.empty()) return 0;
  return static_cast<std::uint64_t>(impl_->NumberOf("SELECT count(*) FROM run"));
}

std::map<std::string, Journal::Request> Journal::Requests() {
  std::map<std::string, Request> requests;
  if (impl_->plan.empty()) return requests;
  Impl::Statement rows(*impl_, "SELECT what, value, written FROM asked WHERE what <> 'plan'");
  while (rows.Step()) requests[rows.Text(0)] = {rows.Text(1), rows.Number(2)};
  return requests;
}

void Journal::Ask(const std::string& what, const std::string& value) {
  Impl::Transaction transaction(*impl_);
  impl_->CheckIsOurs();
  impl_->AskNow(what, value);
  transaction.Commit();
}

std::string Journal::FindFault() {
  Impl::Statement check(*impl_, "PRAGMA quick_check(1)");
  if (!check.Step()) return "it cannot be checked";
  const std::string said = check.Text(0);
  return said == "ok" ? std::string() : said;
}

}  // namespace cdb::journal
