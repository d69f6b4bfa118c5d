#include "runtime/cli/publish/publish.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <system_error>

#include "compiler/plan/input_file.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/publish/digest.h"
#include "runtime/cli/publish/signature.h"
#include "runtime/results/files/safe_file.h"

namespace cdb::publish {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostOfProcessor = 40;

void Remove(std::string& text, std::string_view part) {
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part))
    text.replace(at, part.size(), " ");
}

/// `Intel(R) Xeon(R) Gold 6230 CPU @ 2.10GHz` as `intel-xeon-gold-6230`.
std::string ProcessorWord(std::string text) {
  if (text.empty()) text = "unknown processor";
  text = text.substr(0, text.find('@'));
  for (const char* part : {"(R)", "(TM)", "(tm)", " CPU", " Processor"}) Remove(text, part);
  std::string word;
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 && static_cast<unsigned char>(c) < 128)
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!word.empty() && word.back() != '-')
      word += '-';
  }
  word = word.substr(0, kMostOfProcessor);
  while (word.ends_with('-')) word.pop_back();
  return word;
}

[[noreturn]] void FailWriting(const fs::path& at, const std::string& why) {
  throw options::CommandError(
      fmt::format("{}: cannot publish: {}; nothing was published", at.string(), why));
}

/// Brings a file or a folder to the disk. Some network file systems refuse that for folders.
void Sync(const fs::path& at) {
  const plan::Descriptor opened(open(at.c_str(), O_RDONLY | O_CLOEXEC));
  if (opened.get() < 0 || (fsync(opened.get()) != 0 && errno != EINVAL))
    FailWriting(at, std::strerror(errno));
}

/// A folder `.NAME.tmp` beside the final one, which gets its name when it is complete. Its lock
/// shows that a process is at it; without one, it was left by a killed process, and is emptied.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const fs::path& final_name)
      : final_(final_name),
        path_(final_name.parent_path() / fmt::format(".{}.tmp", final_name.filename().string())) {
    std::error_code error;
    fs::create_directory(path_, error);
    if (error) FailWriting(path_, error.message());
    lock_ = plan::Descriptor(open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (lock_.get() < 0) FailWriting(path_, std::strerror(errno));
    if (flock(lock_.get(), LOCK_EX | LOCK_NB) != 0)
      FailWriting(path_, "another cdb publishes these results now");
    if (!plan::IsAt(lock_.get(), path_))
      FailWriting(path_, "another cdb published these results just now");
    is_ours_ = true;
    for (const auto& entry : fs::directory_iterator(path_)) fs::remove_all(entry.path());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (is_ours_) fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const fs::path& path() const { return path_; }

  void Finish() {
    for (const auto& entry : fs::directory_iterator(path_)) Sync(entry.path());
    Sync(path_);
    std::error_code error;
    fs::rename(path_, final_, error);
    if (error) FailWriting(final_, error.message());
    is_ours_ = false;
    // The results are there, whole. Until the disk knows their name, a power cut can remove it.
    if (const plan::Descriptor place(
            open(final_.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
        place.get() >= 0)
      static_cast<void>(fsync(place.get()));
  }

 private:
  fs::path final_, path_;
  plan::Descriptor lock_;
  bool is_ours_ = false;
};

/// The folder of this name, which exists, must have these results.
void RequireTheSame(const plans::SuiteFolder& read, const fs::path& there) {
  std::vector<std::string> faults = FindDigestFaults(there);
  if (faults.empty()) {
    const Digest digest = ComputeDigest(there);
    for (const auto& [name, hex] : read.facts.sha256)
      if (const auto of = digest.find(name); of == digest.end() || of->second != hex)
        faults.push_back(fmt::format("{}: it is of other results", name));
  }
  if (!faults.empty())
    throw options::CommandError(fmt::format(
        "'{}' exists, but does not have these results as they were published: {}; nothing was "
        "changed: restore it, or remove it and publish again",
        there.string(), fmt::join(faults, "; ")));
}

/// Signs a folder that was published before. True if it was not signed.
bool SignLater(const fs::path& folder, const std::string& key) {
  const Signature before = CheckSignature(folder);
  if (before.state == SignatureState::kNone) {
    Sign(folder, key);
    return true;
  }
  if (!before.fingerprint.empty() && before.fingerprint == FingerprintOf(key)) return false;
  throw options::CommandError(fmt::format(
      "'{}' has a signature already, not by the key of --sign: {}; nothing was changed: remove {} "
      "to sign it again",
      folder.string(), before.text, (folder / kSignatureFile).string()));
}

}  // namespace

bool IsPublished(const fs::path& folder) {
  std::error_code error;
  return fs::exists(fs::symlink_status(folder / kDigestFile, error));
}

CheckedResults CheckResults(const fs::path& folder) {
  CheckedResults checked;
  if (IsPublished(folder)) checked.faults = FindDigestFaults(folder);
  std::error_code error;
  for (const figures::StandardScene& scene : figures::StandardScenes())
    if (const fs::path file = folder / scene.ResultName(); fs::exists(file, error))
      const results::ResultFile proof(file, results::ProofOf::kEveryValue);
  checked.read = plans::ReadSuiteFolder(folder);
  plans::SuiteFaults made = plans::CheckSuite(checked.read, folder);
  checked.faults.insert(checked.faults.end(), made.faults.begin(), made.faults.end());
  checked.facts = std::move(made.facts);
  checked.summary = plans::SuiteSummary(checked.read);
  return checked;
}

void RequireAsPublished(const fs::path& folder) {
  if (!IsPublished(folder)) return;
  if (const auto faults = FindDigestFaults(folder); !faults.empty())
    throw options::CommandError(fmt::format("'{}' is not as it was published: {}", folder.string(),
                                            fmt::join(faults, "; ")));
}

std::string NameOf(const plans::SuiteFolder& read) {
  const results::ResultFile& file = read.files[0]->file;
  return fmt::format("{}-cdb-{}-{}", ProcessorWord(file.ReadProvenance("cpu")),
                     file.ReadProvenance("cdb_version"), ResultsWord(read.facts.sha256));
}

Published Publish(const CheckedResults& results, const fs::path& folder, const fs::path& place,
                  const std::string& key) {
  if (!key.empty()) RequireKey(key);
  std::error_code error;
  fs::create_directories(place, error);
  if (error) FailWriting(place, error.message());
  Published made;
  made.folder = place / NameOf(results.read);
  if (fs::exists(fs::symlink_status(made.folder, error))) {
    RequireTheSame(results.read, made.folder);
    made.outcome = !key.empty() && SignLater(made.folder, key) ? Published::Outcome::kSigned
                                                               : Published::Outcome::kUnchanged;
    return made;
  }
  TemporaryFolder temporary(made.folder);
  for (const auto& [name, hex] : results.read.facts.sha256) {
    fs::copy_file(folder / name, temporary.path() / name, error);
    if (error) FailWriting(temporary.path() / name, error.message());
  }
  files::WriteWhole(results.summary, temporary.path() / plans::kSuiteSummary);
  const Digest digest = ComputeDigest(temporary.path());
  for (const auto& [name, hex] : results.read.facts.sha256)
    if (digest.at(name) != hex) FailWriting(folder / name, "it was changed at the same time");
  for (const auto& [name, hex] : digest)
    made.bytes += static_cast<double>(fs::file_size(temporary.path() / name));
  files::WriteWhole(DigestText(digest), temporary.path() / kDigestFile);
  made.files = digest.size() + 1;
  if (!key.empty()) Sign(temporary.path(), key);
  temporary.Finish();
  return made;
}

}  // namespace cdb::publish
