#include "runtime/results/journal/database.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <thread>
#include <utility>

#include "runtime/results/files/safe_file.h"
#include "runtime/results/journal/journal.h"

namespace cdb::journal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSettings =
    "PRAGMA page_size = 4096; PRAGMA temp_store = MEMORY; PRAGMA cell_size_check = ON;"
    "PRAGMA secure_delete = OFF; PRAGMA trusted_schema = OFF; PRAGMA synchronous = FULL;";
constexpr const char* kOwnFile = "PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = TRUNCATE;";
constexpr const char* kSharedFile = "PRAGMA journal_mode = WAL;";

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

}  // namespace

fs::path Beside(const fs::path& path, std::string_view ending) {
  return path.string() + std::string(ending);
}

bool HasBytes(const fs::path& path) {
  std::error_code error;
  const auto bytes = fs::file_size(path, error);
  return !error && bytes > 0;
}

Database::Copy::Copy(const fs::path& path) {
  std::string name = (fs::temp_directory_path() / "cdb-journal-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr)
    throw files::StoreError(fmt::format("{}: cannot be copied to be read: {}; nothing was changed",
                                        path.string(), std::strerror(errno)));
  folder_ = name;
  std::error_code error;
  fs::copy_file(path, file(), error);
  if (!error) fs::copy_file(Beside(path, "-journal"), Beside(file(), "-journal"), error);
  if (!error) return;
  fs::remove_all(folder_);
  throw files::StoreError(fmt::format("{}: cannot be copied to be read: {}; nothing was changed",
                                      path.string(), error.message()));
}

Database::Copy::~Copy() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

Database::~Database() { Close(); }

void Database::Close() {
  for (const auto& [sql, statement] : statements_) sqlite3_finalize(statement);
  statements_.clear();
  sqlite3_close(std::exchange(db_, nullptr));
}

void Database::Open(const fs::path& file, std::string_view query, int flags, const char* system) {
  Close();
  const int code = sqlite3_open_v2(UriOf(file, query).c_str(), &db_,
                                   flags | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, system);
  sqlite3_extended_result_codes(db_, 1);
  if (code != SQLITE_OK) Fail("open it");
  sqlite3_busy_timeout(db_, 1000 * kPatience);
  sqlite3_db_config(db_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  Do(kSettings);
}

void Database::OpenToWrite(bool is_local) {
  Open(path, "", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, is_local ? nullptr : "unix-none");
  // SQLite does not wait for a lock when it changes the mode.
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(kPatience);
  while (sqlite3_exec(db_, is_local ? kSharedFile : kOwnFile, nullptr, nullptr, nullptr) !=
         SQLITE_OK) {
    if ((sqlite3_errcode(db_) & 0xff) != SQLITE_BUSY || std::chrono::steady_clock::now() > end)
      Fail("write it");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void Database::OpenToRead() {
  // A connection that may not write would leave the files beside the journal behind.
  Open(path, "", SQLITE_OPEN_READWRITE);
  Do("PRAGMA query_only = ON");
}

void Database::OpenUnchanging() { Open(path, "?immutable=1", SQLITE_OPEN_READONLY); }

void Database::OpenCopy() {
  copy_.emplace(path);
  Open(copy_->file(), "", SQLITE_OPEN_READWRITE, "unix-none");
}

void Database::RequireFile(bool must_exist) const {
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
int Database::SystemError() const {
  for (const int which : {SQLITE_FCNTL_JOURNAL_POINTER, SQLITE_FCNTL_FILE_POINTER}) {
    sqlite3_file* file = nullptr;
    int error = 0;
    if (sqlite3_file_control(db_, "main", which, &file) == SQLITE_OK && file != nullptr &&
        file->pMethods != nullptr &&
        file->pMethods->xFileControl(file, SQLITE_FCNTL_LAST_ERRNO, &error) == SQLITE_OK &&
        error != 0)
      return error;
  }
  return sqlite3_system_errno(db_);
}

void Database::Fail(std::string_view doing) const {
  const std::string said = sqlite3_errmsg(db_);
  int error = 0;
  switch (sqlite3_errcode(db_) & 0xff) {
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
      error = access(path.parent_path().c_str(), W_OK) != 0 ? errno : sqlite3_system_errno(db_);
      break;
    default:
      break;
  }
  throw files::StoreError(fmt::format(
      "{}: cannot {}: {}; nothing that was finished is lost: {}", path.string(), doing,
      error != 0 ? std::generic_category().message(error) : said, files::WriteRemedy(error)));
}

void Database::Do(const char* sql) {
  if (sqlite3_exec(db_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) Fail("use it");
}

std::int64_t Database::NumberOf(const char* sql) {
  Statement statement(*this, sql);
  return statement.Step() ? statement.Number(0) : 0;
}

Database::Statement::Statement(Database& database, const char* sql) : database_(database) {
  sqlite3_stmt*& prepared = database.statements_[sql];
  if (prepared == nullptr && sqlite3_prepare_v3(database.db_, sql, -1, SQLITE_PREPARE_PERSISTENT,
                                                &prepared, nullptr) != SQLITE_OK)
    database.Fail("read it");
  statement_ = prepared;
}

Database::Statement::~Statement() {
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
}

Database::Statement& Database::Statement::Bind(std::int64_t number) {
  sqlite3_bind_int64(statement_, ++bound_, number);
  return *this;
}

Database::Statement& Database::Statement::Bind(const std::string& text) {
  sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_STATIC, SQLITE_UTF8);
  return *this;
}

Database::Statement& Database::Statement::Bind(Bytes bytes) {
  if (bytes.empty())
    sqlite3_bind_zeroblob(statement_, ++bound_, 0);
  else
    sqlite3_bind_blob64(statement_, ++bound_, bytes.data(), bytes.size(), SQLITE_STATIC);
  return *this;
}

bool Database::Statement::Step(std::string_view doing) {
  const int code = sqlite3_step(statement_);
  if (code != SQLITE_ROW && code != SQLITE_DONE) database_.Fail(doing);
  return code == SQLITE_ROW;
}

std::string Database::Statement::Text(int column) const {
  const auto bytes = BytesAt(column);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Bytes Database::Statement::BytesAt(int column) const {
  const void* data = sqlite3_column_blob(statement_, column);
  return {static_cast<const std::byte*>(data),
          static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

Database::Transaction::Transaction(Database& database) : database_(database) {
  Statement(database_, "BEGIN IMMEDIATE").Step("write it");
}

Database::Transaction::~Transaction() {
  if (sqlite3_get_autocommit(database_.db_) == 0)
    sqlite3_exec(database_.db_, "ROLLBACK", nullptr, nullptr, nullptr);
}

}  // namespace cdb::journal
