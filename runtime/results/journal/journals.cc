#include "runtime/results/journal/journals.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

namespace cdb::journal {
namespace {

namespace fs = std::filesystem;

/// The files that SQLite has beside a journal.
constexpr std::string_view kBeside[] = {"-wal", "-shm", "-journal"};

void Remove(const fs::path& path) {
  if (unlink(path.c_str()) != 0 && errno != ENOENT)
    throw files::StoreError(
        fmt::format("cannot remove {}: {}", path.string(), std::generic_category().message(errno)));
}

template <typename Visit>
void ForEachName(const fs::path& folder, Visit visit) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    visit(entry->path());
}

}  // namespace

std::vector<fs::path> JournalsIn(const fs::path& folder) {
  std::vector<fs::path> journals;
  ForEachName(folder, [&](const fs::path& path) {
    if (path.filename().string().ends_with(kEnding)) journals.push_back(path);
  });
  std::ranges::sort(journals);
  return journals;
}

Journals::Journals(const std::vector<fs::path>& places) {
  std::uint32_t rank = 0;
  for (const fs::path& place : places) {
    std::error_code error;
    if (fs::is_directory(place, error)) {
      for (const fs::path& file : JournalsIn(place)) Add(file, rank);
    } else if (fs::exists(place, error)) {
      Add(place, rank);
    }
    ++rank;
  }
}

void Journals::Add(const fs::path& file, std::uint32_t rank) {
  const auto index = static_cast<std::uint32_t>(journals_.size());
  journals_.push_back(Journal::OpenToRead(file));
  journals_.back().ForEachRun([&](const Journal::Row& row) {
    Place place = {index, rank, row.number, row.written_ns};
    const auto [found, is_new] = rows_.try_emplace(row.run_id, place);
    if (is_new) return;
    if (place < found->second) std::swap(place, found->second);
    others_.emplace(row.run_id, place);
  });
}

std::optional<Record> Journals::Find(const std::string& run_id) {
  const auto first = rows_.find(run_id);
  if (first == rows_.end()) return std::nullopt;
  const auto read = [&](const Place& place) {
    Journal& journal = journals_[place.journal];
    std::optional<Record> record = journal.ReadRow(place.row);
    if (record && record->run_id != run_id)
      throw DamagedRun(journal.path(), run_id, "its place holds another run");
    return record ? record : journal.Read(run_id);  // perhaps rewritten by another process
  };
  try {
    return read(first->second);
  } catch (const DamagedRun&) {
    const auto [begin, end] = others_.equal_range(run_id);
    std::vector<Place> left;
    for (auto other = begin; other != end; ++other) left.push_back(other->second);
    std::sort(left.begin(), left.end());
    for (const Place& place : left) try {
        return read(place);
      } catch (const DamagedRun&) {
      }
    throw;
  }
}

void Journals::RequirePlan(const plan::Plan& plan, const std::string& plan_sha256) const {
  for (const Journal& one : journals_)
    if (!one.plan_sha256().empty() && one.plan_sha256() != plan_sha256)
      throw files::StoreError(fmt::format(
          "{}: belongs to another plan than `{}`; nothing was merged, and it was left as it is: "
          "start over with --fresh, or choose another name (-o)",
          one.path().string(), plan.benchmark));
}

void Journals::RequireRuns(const std::function<bool(const std::string&)>& is_in_plan) const {
  const std::string* stranger = nullptr;
  for (const auto& [id, place] : rows_)
    if (!is_in_plan(id) && (stranger == nullptr || id < *stranger)) stranger = &id;
  if (stranger != nullptr)
    throw DamagedRun(PathOf(*stranger), *stranger, "the plan has no such run");
}

std::map<std::string, std::string> FindRequests(const fs::path& folder) {
  std::map<std::string, Journal::Request> newest;
  for (const fs::path& file : JournalsIn(folder)) try {
      for (auto& [what, request] : Journal::OpenToRead(file).Requests()) {
        const auto [found, is_new] = newest.try_emplace(what, request);
        if (!is_new && request.written_ns > found->second.written_ns) found->second = request;
      }
    } catch (const files::StoreError&) {
    }
  std::map<std::string, std::string> requests;
  for (auto& [what, request] : newest) requests[what] = std::move(request.value);
  return requests;
}

std::string FindRequest(const fs::path& folder, const std::string& what) {
  const auto requests = FindRequests(folder);
  const auto found = requests.find(what);
  return found == requests.end() ? std::string() : found->second;
}

void Ask(const fs::path& folder, const std::string& plan_sha256, const std::string& what,
         const std::string& value) {
  Journal::OpenToWrite(folder, plan_sha256).Ask(what, value);
}

std::uint64_t CountRuns(const fs::path& folder) {
  std::uint64_t runs = 0;
  for (const fs::path& file : JournalsIn(folder)) runs += Journal::OpenToRead(file).CountRuns();
  return runs;
}

bool HasAllRuns(const plan::Plan& plan, const std::vector<fs::path>& places) {
  const Journals journals(places);
  bool has_all = true;
  plan.ForEachRun([&](const std::string& id, const auto&, std::uint64_t) {
    has_all = has_all && journals.Has(id);
  });
  return has_all && std::ranges::all_of(plan.references,
                                        [&](const plan::Run& run) { return journals.Has(run.id); });
}

void RemoveJournals(const fs::path& folder) {
  std::vector<fs::path> with_request, others;
  for (const fs::path& file : JournalsIn(folder)) {
    bool has_request = false;
    try {
      const auto requests = Journal::OpenToRead(file).Requests();
      has_request = requests.contains(kRetry) || requests.contains(kFresh);
    } catch (const files::StoreError&) {
    }
    (has_request ? with_request : others).push_back(file);
  }
  for (const auto* files : {&with_request, &others})
    for (const fs::path& file : *files) Remove(file);
  // SQLite does not take such a file for part of a journal that begins anew.
  ForEachName(folder, [](const fs::path& path) {
    const std::string name = path.filename().string();
    for (const std::string_view ending : kBeside)
      if (name.ends_with(std::string(kEnding) + std::string(ending))) Remove(path);
  });
}

}  // namespace cdb::journal
