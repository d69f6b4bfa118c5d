#include "runtime/sweep/cluster/slurm.h"

#include <fmt/format.h>

#include <charconv>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "runtime/sweep/process/program.h"

namespace cdb::cluster {
namespace {

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

[[noreturn]] void FailMissing(const std::string& program) {
  throw std::runtime_error(
      fmt::format("{} is not in PATH: submit sweeps on a login node of the cluster, which has "
                  "Slurm; without Slurm, use GNU parallel or ssh (`cdb doc cluster`)",
                  program));
}

/// The output of a program; nullopt if it is missing or fails.
std::optional<std::string> Ask(const std::vector<std::string>& words) {
  const auto end = process::RunProgram(words);
  if (!end || end->status != 0) return std::nullopt;
  return end->out;
}

std::uint64_t NumberIn(std::string_view text) {
  std::uint64_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// The tasks that failed, from lines of two fields, `6|FAILED`.
std::map<std::uint64_t, std::string> FailuresIn(const std::string& text) {
  std::map<std::uint64_t, std::string> failures;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto bar = line.find('|');
    if (bar == std::string::npos) continue;
    const auto place = line.rfind('_', bar);  // sacct prints the task as 12_6
    const std::uint64_t task =
        NumberIn(std::string_view(line).substr(place == std::string::npos ? 0 : place + 1));
    const std::string state = line.substr(bar + 1);
    if (task > 0 && !state.starts_with("COMPLETED")) failures[task] = state;
  }
  return failures;
}

}  // namespace

void RequireSlurm() {
  if (!process::FindProgram("sbatch")) FailMissing("sbatch");
}

std::string Submit(const Job& job) {
  const auto end = process::RunProgram(job.words, job.script);
  if (!end) FailMissing(job.words[0]);
  // `12` or `12;cluster`
  const std::string id = FirstLine(end->out).substr(0, end->out.find_first_of(";\n"));
  if (end->status == 0 && !id.empty() && id.find_first_not_of("0123456789") == std::string::npos)
    return id;
  throw std::runtime_error(fmt::format(
      "sbatch refuses the job: {}; nothing runs. --dry-run shows what is submitted; partition, "
      "time, account and other options are those of cdb submit",
      end->err.empty() ? fmt::format("exit status {}", end->status) : process::LastLine(end->err)));
}

void Cancel(const std::string& id) { static_cast<void>(process::RunProgram({"scancel", id})); }

std::optional<ActiveTasks> FindActive(const std::string& array, const std::string& merge,
                                      std::string& why) {
  // One line for each task; tasks that have ended are not listed.
  const auto end = process::RunProgram(
      {"squeue", "--noheader", "--array", "--jobs=" + array + "," + merge, "--format=%T|%r"});
  if (!end) FailMissing("squeue");
  ActiveTasks active;
  if (end->status != 0) {
    // Slurm forgets jobs some minutes after their end (MinJobAge).
    if (end->err.find("Invalid job id") != std::string::npos) return active;
    why = process::LastLine(end->err);
    return std::nullopt;
  }
  std::istringstream lines(end->out);
  for (std::string line; std::getline(lines, line);) {
    const auto bar = line.find('|');
    if (bar == std::string::npos) continue;
    const std::string reason = line.substr(bar + 1);
    if (line.starts_with("PENDING")) {
      ++active.waiting;
      // The merge job always waits for the array.
      if (reason != "Dependency" && reason != "None") active.reason = reason;
    } else {
      ++active.running;
    }
  }
  return active;
}

std::map<std::uint64_t, std::string> FindFailures(const std::string& array) {
  if (const auto told = Ask({"sacct", "--noheader", "--allocations", "--parsable2",
                             "--jobs=" + array, "--format=JobID,State"});
      told && !told->empty())
    return FailuresIn(*told);
  const auto told =
      Ask({"squeue", "--noheader", "--array", "--states=all", "--jobs=" + array, "--format=%K|%T"});
  return told ? FailuresIn(*told) : std::map<std::uint64_t, std::string>();
}

Capacity FindCapacity(const std::string& partition) {
  Capacity capacity;
  std::vector<std::string> words = {"sinfo", "--noheader", "--format=%P|%C"};
  if (!partition.empty()) words.push_back("--partition=" + partition);
  // `bench*|0/2/0/2`: the default partition has a star; numbers are allocated, idle, other and all
  // processors.
  std::istringstream lines(Ask(words).value_or(""));
  for (std::string line; std::getline(lines, line);) {
    const auto bar = line.find('|');
    if (bar == std::string::npos || bar == 0) continue;
    if (partition.empty() && line[bar - 1] != '*') continue;
    capacity.cores += NumberIn(std::string_view(line).substr(line.rfind('/') + 1));
  }
  std::istringstream settings(Ask({"scontrol", "show", "config"}).value_or(""));
  for (std::string line; std::getline(settings, line);)
    if (line.starts_with("MaxArraySize"))
      if (const auto size = NumberIn(std::string_view(line).substr(line.rfind(' ') + 1)); size > 1)
        capacity.most_tasks = size - 1;  // size is one more than the largest index
  return capacity;
}

}  // namespace cdb::cluster
