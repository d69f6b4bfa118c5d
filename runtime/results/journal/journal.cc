#include "runtime/results/journal/journal.h"

#include <fmt/format.h>
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
#include <span>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "runtime/protocol/machine/machine.h"
#include "runtime/results/files/local_disk.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/files/seal.h"
#include "runtime/results/journal/database.h"

namespace cdb::journal {
namespace {

namespace fs = std::filesystem;

/// In the head of the file, at byte 68: `cdbj`.
constexpr std::uint32_t kApplication = 0x6364626a;
constexpr int kVersion = 1;
constexpr std::string_view kMagic("SQLite format 3\0", 16);
/// SQLite's limit of a value is 1 GB.
constexpr std::size_t kMostBytes = 500'000'000;

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

/// The tables of one journal.
struct Journal::Impl : Database {
  using Database::Database;

  /// A row of `about`.
  struct Shared {
    std::int64_t number = 0;
    std::uint64_t checksum = 0;
    std::shared_ptr<const About> about;
  };

  std::string PlanInFile() {
    Statement statement(*this, "SELECT value FROM asked WHERE what = 'plan'");
    return statement.Step() ? statement.Text(0) : std::string();
  }

  /// False if the file has no tables yet.
  bool CheckHead() {
    // In one statement, and so of one commit: another process may be making the tables.
    std::int64_t version = 0, tables = 0;
    {
      Statement head(*this,
                     "SELECT user_version, (SELECT count(*) FROM sqlite_schema) "
                     "FROM pragma_user_version");
      head.Step();
      version = head.Number(0);
      tables = head.Number(1);
    }
    if (version == 0 && tables == 0) {
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
    const fs::path file = OpenedFile();
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

  /// The row of `about`; written now, and added to `added`, if this process has not written it yet.
  Shared SharedOf(const std::shared_ptr<const About>& about, std::vector<Shared>& added) {
    for (const std::vector<Shared>* all : {&written, &added})
      if (const auto known = std::ranges::find(*all, about, &Shared::about); known != all->end())
        return *known;
    const std::vector<std::byte> bytes = about->Encode();
    Statement(*this, "INSERT INTO about(bytes) VALUES(?)").Bind(Bytes(bytes)).Step("write it");
    added.push_back({LastRow(), files::Checksum(bytes), about});
    return added.back();
  }

  void WriteRow(const Record& record, std::int64_t now, const Shared& shared) {
    const std::vector<std::byte> facts = record.EncodeFacts();
    const Bytes bytes(record.bytes);
    Statement(*this, "DELETE FROM more WHERE run = (SELECT number FROM run WHERE id = ?)")
        .Bind(record.run_id)
        .Step("write it");
    const std::uint64_t checksum = ChecksumOfRun(record.run_id, now, shared.checksum, facts, bytes);
    Statement(*this,
              "INSERT OR REPLACE INTO run(id, written, about, checksum, facts, chunks) "
              "VALUES(?, ?, ?, ?, ?, ?)")
        .Bind(record.run_id)
        .Bind(now)
        .Bind(shared.number)
        .Bind(static_cast<std::int64_t>(checksum))
        .Bind(Bytes(facts))
        .Bind(bytes.first(std::min(bytes.size(), kMostBytes)))
        .Step("write it");
    const std::int64_t row = LastRow();
    for (std::size_t at = kMostBytes; at < bytes.size(); at += kMostBytes)
      Statement(*this, "INSERT INTO more VALUES(?, ?, ?)")
          .Bind(row)
          .Bind(static_cast<std::int64_t>(at))
          .Bind(bytes.subspan(at, std::min(bytes.size() - at, kMostBytes)))
          .Step("write it");
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

  std::string plan;
  ino_t inode = 0;
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
  impl->OpenToWrite(files::IsOnLocalDisk(folder));
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
      impl->OpenUnchanging();
    } else {
      impl->OpenCopy();
    }
    has_tables = impl->CheckHead();
  } else {
    try {
      impl->OpenToRead();
      has_tables = impl->CheckHead();
    } catch (const DamagedJournal&) {
      throw;
    } catch (const files::StoreError&) {
      // On a full disk, or where this process may not write, there is no place for what readers
      // share. Without a log, the file can be read as it stands.
      if (HasBytes(Beside(file, "-wal"))) throw;
      impl->OpenUnchanging();
      has_tables = impl->CheckHead();
    }
  }
  if (has_tables) impl->plan = impl->PlanInFile();
  return Journal(std::move(impl));
}

void Journal::RequireInPlace() const { impl_->RequireInPlace(); }

void Journal::Write(std::span<const Record> records) {
  const std::int64_t now = Now_ns();
  std::vector<Impl::Shared> added;
  Database::Transaction transaction(*impl_);
  impl_->CheckIsOurs();
  for (const Record& record : records)
    impl_->WriteRow(record, now, impl_->SharedOf(record.about, added));
  transaction.Commit();
  impl_->written.insert(impl_->written.end(), added.begin(), added.end());
}

void Journal::Forget(const std::string& run_id) {
  Database::Transaction transaction(*impl_);
  Database::Statement(*impl_, "DELETE FROM run WHERE id = ?").Bind(run_id).Step("write it");
  Database::Statement(*impl_, "DELETE FROM asked WHERE what LIKE 'part %'").Step("write it");
  transaction.Commit();
}

void Journal::Restart(const std::string& plan_sha256, const std::string& asked) {
  Database::Transaction transaction(*impl_);
  // Rows of `about` stay: another process may be using their numbers.
  for (const char* sql : {"DELETE FROM run", "DELETE FROM more", "DELETE FROM asked"})
    Database::Statement(*impl_, sql).Step("write it");
  impl_->AskNow("plan", plan_sha256);
  if (!asked.empty()) impl_->AskNow(asked, plan_sha256);
  transaction.Commit();
  impl_->plan = plan_sha256;
}

bool Journal::Has(const std::string& run_id) {
  if (impl_->plan.empty()) return false;
  return Database::Statement(*impl_, "SELECT 1 FROM run WHERE id = ?").Bind(run_id).Step();
}

std::optional<Record> Journal::Read(const std::string& run_id) {
  if (impl_->plan.empty()) return std::nullopt;
  Database::Statement found(*impl_,
                            "SELECT number, id, written, about, checksum, facts, chunks FROM run "
                            "WHERE id = ?");
  if (!found.Bind(run_id).Step()) return std::nullopt;
  Record record = impl_->RecordAt(found);
  if (record.run_id != run_id) throw DamagedRun(impl_->path, run_id, "its place holds another run");
  return record;
}

std::optional<Record> Journal::ReadRow(std::int64_t row) {
  Database::Statement found(*impl_,
                            "SELECT number, id, written, about, checksum, facts, chunks FROM run "
                            "WHERE number = ?");
  if (!found.Bind(row).Step()) return std::nullopt;
  return impl_->RecordAt(found);
}

void Journal::ForEachRun(const VisitRow& visit, std::int64_t after, bool reversed) {
  if (impl_->plan.empty()) return;
  // From the table, and not from the index of ids: a row is found though its index is damaged.
  Database::Statement rows(
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
  Database::Statement rows(*impl_, "SELECT what, value, written FROM asked WHERE what <> 'plan'");
  while (rows.Step()) requests[rows.Text(0)] = {rows.Text(1), rows.Number(2)};
  return requests;
}

void Journal::Ask(const std::string& what, const std::string& value) {
  Database::Transaction transaction(*impl_);
  impl_->CheckIsOurs();
  impl_->AskNow(what, value);
  transaction.Commit();
}

std::string Journal::FindFault() {
  Database::Statement check(*impl_, "PRAGMA quick_check(1)");
  if (!check.Step()) return "it cannot be checked";
  const std::string said = check.Text(0);
  return said == "ok" ? std::string() : said;
}

}  // namespace cdb::journal
