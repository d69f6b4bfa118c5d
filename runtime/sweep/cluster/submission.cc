#include "runtime/sweep/cluster/submission.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>

#include <cerrno>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "runtime/results/journal/journals.h"
#include "runtime/terminal/console.h"

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

namespace {

constexpr std::string_view kLogBegin = "slurm-", kLogEnding = ".log";

/// A network file system shows new files to other nodes within a minute (acdirmax of nfs(5)).
constexpr int kVisibleAfter_s = 90;

/// Quotes a path as one word for the shell.
std::string Quoted(const fs::path& path) {
  const std::string text = path.string();
  if (text.find_first_of("\n\r") != std::string::npos)
    throw std::invalid_argument(
        fmt::format("'{}' has a line break in its name, which a job script cannot contain; name "
                    "another file or folder",
                    text));
  return terminal::ShellWord(text);
}

/// The head of a script: waits until the node sees the files that the script needs.
std::string Begin(const SweepFiles& files) {
  return fmt::format(
      R"(#!/bin/sh
refuse() {{ echo "cdb on $(hostname): $1" >&2; exit 2; }}
cd {folder} || refuse 'this node does not have the folder above; start from a folder that all nodes share'
[ -x {program} ] || refuse 'this node does not have cdb at the path where it was submitted; install it where all nodes see it'
tries=0
until [ -r {plan} ]; do
  tries=$((tries + 1))
  [ $tries -lt {wait} ] || refuse 'this node does not see the folder of the sweep; name a results file (-o) in a folder that all nodes share'
  sleep 1
done
)",
      fmt::arg("folder", Quoted(files.folder)), fmt::arg("program", Quoted(files.program)),
      fmt::arg("plan", Quoted(files.plan)), fmt::arg("wait", kVisibleAfter_s));
}

std::vector<std::string> CommonWords(const Sweep& sweep, const JobOptions& options) {
  // Logs by file name only: sbatch would expand % signs in a path.
  std::vector<std::string> words = {
      "sbatch",     "--parsable", "--chdir=" + sweep.files.runs.string(),
      "--ntasks=1", "--requeue",  "--open-mode=append"};
  const auto add = [&words](std::string_view option, const std::string& value) {
    if (!value.empty()) words.push_back(fmt::format("--{}={}", option, value));
  };
  add("partition", options.partition);
  add("time", options.time);
  add("account", options.account);
  return words;
}

std::string CommandText(const Job& job) {
  std::string text;
  for (const std::string& word : job.words)
    text +=
        (text.empty() ? "" : " ") +
        (word == "--dependency=afterany:$array" ? "\"" + word + "\"" : terminal::ShellWord(word));
  return text;
}

}  // namespace

std::string IndexList(const std::vector<std::uint64_t>& indices) {
  std::vector<std::string> ranges;
  for (std::size_t i = 0; i < indices.size();) {
    std::size_t end = i + 1;
    while (end < indices.size() && indices[end] == indices[end - 1] + 1) ++end;
    ranges.push_back(end - i == 1 ? fmt::format("{}", indices[i])
                                  : fmt::format("{}-{}", indices[i], indices[end - 1]));
    i = end;
  }
  return fmt::format("{}", fmt::join(ranges, ","));
}

/// All tasks if the list of the missing ones exceeds the largest argument of a program (128 KiB on
/// Linux); tasks without missing runs end at once.
std::string TasksToSubmit(const Sweep& sweep) {
  constexpr std::size_t kLongest = 100'000;
  const std::string missing = IndexList(sweep.missing);
  return missing.size() <= kLongest ? missing : fmt::format("1-{}", sweep.tasks);
}

Job ArrayJob(const Sweep& sweep, const JobOptions& options) {
  Job job = {CommonWords(sweep, options), {}};
  const auto add = [&job](std::string word) { job.words.push_back(std::move(word)); };
  add("--job-name=cdb-" + sweep.name);
  add("--array=" + TasksToSubmit(sweep));
  add(fmt::format("--cpus-per-task={}", sweep.threads));
  // A core for each thread: a second thread on the same core would share its units.
  add("--hint=nomultithread");
  add(fmt::format("--output={}%A_%a{}", kLogBegin, kLogEnding));
  if (options.is_exclusive) add("--exclusive");
  job.words.insert(job.words.end(), options.more.begin(), options.more.end());
  const SweepFiles& files = sweep.files;
  job.script = Begin(files) +
               fmt::format(
                   R"(for try in 1 2 3; do
  {program} run -q {plan} -o {out} --shard "$SLURM_ARRAY_TASK_ID/{tasks}"
  status=$?
  case $status in
    0 | 3) exit 0 ;;  # a run that failed is a result
    1 | 2 | 129 | 130 | 143) exit $status ;;  # another try would not help, or it was asked to stop
  esac
  echo "cdb ended with status $status; finished runs are kept" >&2
done
exit 75  # RequeueExit of slurm.conf may name it
)",
                   fmt::arg("program", Quoted(files.program)), fmt::arg("plan", Quoted(files.plan)),
                   fmt::arg("out", Quoted(files.out)), fmt::arg("tasks", sweep.tasks));
  return job;
}

Job MergeJob(const Sweep& sweep, const JobOptions& options, const std::string& array) {
  Job job = {CommonWords(sweep, options), {}};
  job.words.push_back("--job-name=cdb-merge-" + sweep.name);
  // `afterany`: the runs are merged even if a task failed.
  job.words.push_back("--dependency=afterany:" + array);
  job.words.push_back(fmt::format("--output={}%j{}", kLogBegin, kLogEnding));
  job.words.insert(job.words.end(), options.more.begin(), options.more.end());
  job.script = Begin(sweep.files) + fmt::format("exec {} merge --wait {} --remove -o {} {}\n",
                                                Quoted(sweep.files.program), kVisibleAfter_s,
                                                Quoted(sweep.files.out), Quoted(sweep.files.runs));
  return job;
}

std::string DryRunText(const Sweep& sweep, const JobOptions& options,
                       const std::string& make_plan) {
  const Job array = ArrayJob(sweep, options), merge = MergeJob(sweep, options, "$array");
  return fmt::format(
      "#!/bin/sh\nmkdir -p {} && {} || exit\narray=$({} <<'END_OF_TASK'\n{}END_OF_TASK\n) || "
      "exit\narray=${{array%%;*}}\n"
      "{} <<'END_OF_MERGE'\n{}END_OF_MERGE\n",
      Quoted(sweep.files.runs), make_plan, CommandText(array), array.script, CommandText(merge),
      merge.script);
}

std::string LogName(const std::string& array, std::uint64_t task) {
  return fmt::format("{}{}_{}{}", kLogBegin, array, task, kLogEnding);
}

bool IsLogName(const std::string& name) {
  return name.size() > kLogBegin.size() + kLogEnding.size() && name.starts_with(kLogBegin) &&
         name.ends_with(kLogEnding) &&
         std::string_view(name)
                 .substr(kLogBegin.size(), name.size() - kLogBegin.size() - kLogEnding.size())
                 .find_first_not_of("0123456789_") == std::string_view::npos;
}

}  // namespace cdb::cluster
