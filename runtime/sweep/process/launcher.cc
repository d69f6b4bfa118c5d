#include "runtime/sweep/process/launcher.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <numeric>
#include <string_view>
#include <system_error>
#include <utility>

#include "compiler/schema/value.h"
#include "dsl/text/utf8.h"
#include "runtime/protocol/bytes_text.h"
#include "runtime/protocol/recording.h"
#include "runtime/results/examine.h"
#include "runtime/sweep/process/process.h"

namespace cdb::process {
namespace {

/// The text that a worker wrote before it ended; empty if a crash damaged it.
std::string LinesOf(std::string text) {
  const bool is_text = std::ranges::all_of(
      text, [](unsigned char c) { return c < 0x7f && (c >= ' ' || c == '\n'); });
  return is_text ? text : std::string();
}

bool IsHexDigit(char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); }

std::string CrashText(const ProcessEnd& end, std::string_view trouble, const std::string& where) {
  std::string text(trouble);
  if (end.wait_status != 0) text = "the worker " + EndText(end.wait_status);
  if (!where.empty()) text += " in " + where;
  return end.last_lines.empty() ? text : text + ": " + end.last_lines;
}

/// Sets the values of `cycle` and later cycles to `none`. `extents` are those of the series, the
/// cycle at `cycle_dimension`.
template <typename T>
void ClearFrom(std::span<T> values, std::span<const std::uint64_t> extents,
               std::size_t cycle_dimension, std::uint64_t cycle, T none) {
  const std::uint64_t cycles = extents[cycle_dimension];
  std::size_t per_cycle = 1;
  for (const std::uint64_t extent : extents.subspan(cycle_dimension + 1)) per_cycle *= extent;
  const std::size_t row = cycles * per_cycle;
  if (row == 0) return;
  for (std::size_t at = 0; at < values.size(); at += row)
    std::ranges::fill(values.subspan(at + cycle * per_cycle, (cycles - cycle) * per_cycle), none);
}

void ClearUnfinished(protocol::Recording& recording, const protocol::RunExtents& run,
                     std::uint64_t n_cycles) {
  for (const protocol::Series& series : protocol::AllSeries()) {
    const auto dimension = series.CycleDimension();
    if (recording.Bytes(series).empty() || !dimension) continue;
    const std::vector<std::uint64_t> extents = series.Extents(run);
    if (series.type == protocol::SeriesType::kInt32) {
      ClearFrom<std::int32_t>(recording.Values<std::int32_t>(series), extents, *dimension, n_cycles,
                              -1);
    } else {
      ClearFrom<double>(recording.Values<double>(series), extents, *dimension, n_cycles,
                        std::numeric_limits<double>::quiet_NaN());
    }
  }
}

/// The contacts of the first cycles; of fewer cycles if a worker died before it had written the
/// contacts of all that it finished.
std::vector<protocol::ContactRecord> ReadContacts(int fd, std::span<const std::int32_t> counts,
                                                  std::uint64_t& n_cycles) {
  struct stat status = {};
  if (fstat(fd, &status) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot read the contacts of a run");
  const std::uint64_t written =
      static_cast<std::uint64_t>(status.st_size) / sizeof(protocol::ContactRecord);
  std::uint64_t wanted = 0;
  std::uint64_t cycle = 0;
  for (; cycle < n_cycles; ++cycle) {
    const auto count = static_cast<std::uint64_t>(std::max(counts[cycle], 0));
    if (wanted + count > written) break;
    wanted += count;
  }
  n_cycles = cycle;
  std::vector<protocol::ContactRecord> contacts(wanted);
  auto* to = reinterpret_cast<char*>(contacts.data());
  for (std::size_t at = 0; at < wanted * sizeof(protocol::ContactRecord);) {
    const ssize_t got =
        pread(fd, to + at, wanted * sizeof(protocol::ContactRecord) - at, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      throw std::system_error(got < 0 ? errno : EIO, std::generic_category(),
                              "cannot read the contacts of a run");
    at += static_cast<std::size_t>(got);
  }
  return contacts;
}

bool HasExited(const ProcessEnd& end) {
  return WIFEXITED(end.wait_status) && WEXITSTATUS(end.wait_status) == 0;
}

bool HasMemoryLimit(const plan::Run& run) { return run.scene.world.WordOr("memory").empty(); }

/// A failed allocation alone is not enough: the run may have recovered and failed for another
/// reason.
bool EndedOutOfMemory(const protocol::RecordingHeader& header, protocol::WorkerOutcome outcome) {
  if (header.is_out_of_memory.load(std::memory_order_relaxed) == 0) return false;
  if (outcome != protocol::WorkerOutcome::kFailed) return true;
  const std::string message = header.message.str();
  // The second text comes from a plug-in.
  return message.starts_with(protocol::kOutOfMemory) || message.ends_with(std::bad_alloc().what());
}

/// Sets the status of the run and its message. `reported`: the number of cycles that the worker
/// reported as finished; the result may have fewer.
void SetStatus(const plan::Run& run, const ProcessEnd& end, const protocol::RecordingHeader& header,
               std::uint64_t reported, results::RunResult& result) {
  const protocol::WorkerOutcome outcome = header.outcome.load(std::memory_order_acquire);
  const std::uint64_t cycles = run.scene.world.Count("cycles");
  const std::string where =
      protocol::PluginCallText(header.plugin_call.load(std::memory_order_relaxed), run.scene);
  const bool has_exited = HasExited(end);
  if (has_exited && outcome == protocol::WorkerOutcome::kDone && result.n_cycles == cycles) {
    result.status = results::Status::kDone;
    result.state_hash = header.state_hash.str();
    result.message = text::Printable(header.message.str());
  } else if (HasMemoryLimit(run) && !end.is_timed_out && EndedOutOfMemory(header, outcome)) {
    result.status = results::Status::kFailed;
    result.message = fmt::format(
        "ended at its memory limit of {} after {} of {} cycles{}{}; raise `memory`, or use fewer "
        "objects",
        protocol::BytesText(run.scene.world.Real("memory")), result.n_cycles, cycles,
        where.empty() ? "" : ", in ", where);
  } else if (has_exited && outcome == protocol::WorkerOutcome::kFailed) {
    result.status = results::Status::kFailed;
    result.message = text::Printable(header.message.str());
    std::ranges::replace(result.message, '\n', ' ');
    if (result.message.empty()) result.message = "the worker failed without a message";
  } else if (end.is_timed_out && (!has_exited || outcome == protocol::WorkerOutcome::kAgain)) {
    result.status = results::Status::kTimedOut;
    const std::string settling = protocol::SettlingText(header.settling);
    result.message = fmt::format("ended at its timeout of {} s after {} of {} cycles{}{}",
                                 schema::FormatReal(run.scene.world.Real("timeout")),
                                 result.n_cycles, cycles, where.empty() ? "" : ", in ", where);
    if (!settling.empty())
      result.message += fmt::format(
          ", while its pile settled ({}); use a longer timeout: a pile settles once for all its "
          "runs",
          settling);
  } else {
    result.status = results::Status::kCrashed;
    std::string trouble = "the worker ended without a report";
    if (outcome == protocol::WorkerOutcome::kDone)
      trouble = reported < cycles
                    ? fmt::format("the worker ended after {} of {} cycles", reported, cycles)
                    : "the worker ended without all of its contacts";
    result.message = CrashText(end, trouble, where);
    if (HasMemoryLimit(run))
      result.message += fmt::format("; its memory was limited to {}",
                                    protocol::BytesText(run.scene.world.Real("memory")));
  }
}

/// How many objects there are to move, and to what part of the run they were asleep.
void AddObjectCounts(const plan::Run& run, const protocol::Recording& recording,
                     results::RunResult& result) {
  const auto asleep =
      recording.Ints("asleep").first(std::min(recording.Ints("asleep").size(), result.n_cycles));
  if (asleep.empty()) return;
  // A plug-in can write into the recording.
  const double moving = recording.header().scales.moving_objects;
  if (moving >= 0 && moving <= static_cast<double>(run.scene.ObjectCount()))
    result.scalars.moving_objects = moving;
  result.scalars.mean_asleep =
      std::accumulate(asleep.begin(), asleep.end(), 0.0) / static_cast<double>(asleep.size());
}

/// A recording is memory that the code of a plug-in can write, and a clock can be broken: values
/// that no run can have must not reach the results, which could then not be read.
void DropIfImpossible(std::uint64_t cycles, results::RunResult& result) {
  std::string fault = results::FindFault(result, cycles);
  if (fault.empty() && !std::ranges::all_of(result.state_hash, IsHexDigit))
    fault = "its state hash is none";
  if (fault.empty()) return;
  const std::string why = fmt::format(
      "what it recorded cannot be and was dropped: {}; a plug-in wrote into it, or the "
      "clock went backwards",
      fault);
  if (result.status == results::Status::kDone) {
    result.status = results::Status::kFailed;
    result.message = why;
  } else {
    result.message += "; " + why;
  }
  result.n_cycles = 0;
  result.state_hash.clear();
  result.scalars = {};
  result.contacts.clear();
}

}  // namespace

results::RunResult Collect(const plan::Run& run, const ProcessEnd& end,
                           protocol::Recording& recording, int contacts_fd) {
  const protocol::RecordingHeader& header = recording.header();
  const std::uint64_t cycles = run.scene.world.Count("cycles");
  results::RunResult result;
  result.n_cycles = std::min(header.cycles_done.load(std::memory_order_acquire), cycles);
  const std::uint64_t reported = result.n_cycles;
  if (run.scene.world.Lists("record", "contacts"))
    result.contacts = ReadContacts(contacts_fd, recording.Ints("contacts"), result.n_cycles);

  const bool has_exited = HasExited(end);
  SetStatus(run, end, header, reported, result);
  const auto text = [has_exited](const auto& shared) {
    return has_exited ? text::Printable(shared.str()) : LinesOf(shared.str());
  };
  result.omitted = text(header.omitted);
  result.decisions = text(header.decisions);
  result.models = text(header.models);
  result.scalars = header.scalars;
  for (const protocol::Series& series : protocol::AllSeries())
    if (const auto bytes = recording.Bytes(series); !bytes.empty())
      result.series.emplace_back(&series, bytes);
  DropIfImpossible(cycles, result);
  if (result.status != results::Status::kFailed) {
    const protocol::Verdict ending =
        result.status == results::Status::kTimedOut  ? protocol::Verdict::kTimedOut
        : result.status == results::Status::kCrashed ? protocol::Verdict::kCrashed
                                                     : protocol::Verdict::kUnknown;
    result.judgement = protocol::Judge(run.scene, recording, result.n_cycles, ending);
    AddObjectCounts(run, recording, result);
  }
  if (result.status != results::Status::kDone)
    ClearUnfinished(recording, protocol::ExtentsOf(run.scene), result.n_cycles);

  return result;
}

}  // namespace cdb::process
