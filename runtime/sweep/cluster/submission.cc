#include "runtime/sweep/cluster/submission.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <cerrno>
#include <sstream>
#include <system_error>

#include "runtime/results/journal/journals.h"
#include "runtime/sweep/cluster/job_script.h"

namespace cdb::cluster {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockName = "submitting";

}  // namespace

std::optional<Submission> ReadSubmission(const fs::path& folder) {
  std::istringstream in(journal::FindRequest(folder, journal::kSubmission));
  Submission submission;
  if (!(in >> submission.plan_sha256 >> submission.tasks >> submission.array >> submission.merge) ||
      submission.tasks < 1)
    return std::nullopt;
  return submission;
}

void WriteSubmission(const Submission& submission, const fs::path& folder) {
  journal::Ask(folder, submission.plan_sha256, journal::kSubmission,
               fmt::format("{} {} {} {}", submission.plan_sha256, submission.tasks,
                           submission.array, submission.merge));
}

SubmissionLock::SubmissionLock(const fs::path& folder)
    : file_(open((folder / kLockName).c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666)) {
  is_held_ = file_.get() < 0 || flock(file_.get(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

void RemoveSubmission(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (IsLogName(entry->path().filename().string())) {
      std::error_code ignored;
      fs::remove(entry->path(), ignored);
    }
  fs::remove(folder / kLockName, error);
}

}  // namespace cdb::cluster
