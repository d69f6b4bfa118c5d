#include "runtime/cli/plans/git_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>

#include "dsl/text/utf8.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/sweep/process/program.h"

namespace cdb::plans {
namespace {

/// The least number of digits that git itself abbreviates a hash to.
constexpr std::size_t kLeastDigits = 7;

using Places = std::map<std::string, std::size_t, std::less<>>;

bool IsHexDigit(char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); }

/// The place of the only commit whose hash begins with `digits`.
std::optional<std::size_t> FindCommit(const Places& places, std::string_view digits) {
  const auto found = places.lower_bound(digits);
  if (found == places.end() || !found->first.starts_with(digits)) return std::nullopt;
  const auto next = std::next(found);
  if (next != places.end() && next->first.starts_with(digits)) return std::nullopt;
  return found->second;
}

/// The commit that a name such as `crowd-1a2b3c4.h5` or `1a2b3c4/crowd.h5` has.
std::optional<std::size_t> CommitIn(const Places& places, std::string_view name) {
  std::optional<std::size_t> last;
  for (std::size_t begin = 0; begin < name.size();) {
    std::size_t end = begin;
    while (end < name.size() && IsHexDigit(name[end])) ++end;
    // A word of letters and digits is a hash as a whole, or not at all.
    const auto is_word = [&](std::size_t at) {
      return at < name.size() && (std::isalnum(static_cast<unsigned char>(name[at])) != 0);
    };
    if (end - begin >= kLeastDigits && !is_word(end) && (begin == 0 || !is_word(begin - 1)))
      if (const auto place = FindCommit(places, name.substr(begin, end - begin))) last = place;
    begin = end + 1;
  }
  return last;
}

/// Why a file of a commit that is not of the main line is left out. Such a commit lacks what others
/// changed meanwhile, so that its neighbours in the list differ by more than its own change.
std::string OfABranch(const std::vector<history::Commit>& commits, std::size_t place) {
  constexpr std::size_t kShort = 9;
  // The last commit is of the main line.
  while (!commits[place].is_main) ++place;
  return fmt::format("its commit is of a branch that {} merged; measure that one",
                     commits[place].hash.substr(0, kShort));
}

}  // namespace

std::vector<history::Commit> ReadCommits(const std::string& repository) {
  const auto end = process::RunProgram({"git", "-C", repository, "log", "--no-show-signature",
                                        "--topo-order", "--reverse", "--format=%H %P%x09%s"});
  if (!end)
    throw options::CommandError(
        "--git needs the program git, which is in no folder of PATH; install it, or leave out "
        "--git: "
        "files are then in order of the times at which they were measured");
  if (end->status != 0)
    throw options::CommandError(
        fmt::format("--git {}: git log failed: {}", repository, text::Printable(end->err)));
  std::vector<history::Commit> commits;
  std::vector<std::string_view> first_parents;
  std::string_view rest = end->out;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    const std::size_t tab = std::min(line.find('\t'), line.size());
    const std::string_view hashes = line.substr(0, tab);
    const std::size_t own = std::min(hashes.find(' '), hashes.size());
    const std::string_view parents = hashes.substr(std::min(own + 1, hashes.size()));
    commits.push_back({std::string(hashes.substr(0, own)),
                       text::Printable(std::string(line.substr(std::min(tab + 1, line.size())))),
                       false});
    first_parents.push_back(parents.substr(0, parents.find(' ')));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
  }
  // Parents are listed before their children.
  std::string_view next = commits.empty() ? std::string_view() : commits.back().hash;
  for (std::size_t i = commits.size(); i-- > 0;) {
    if (commits[i].hash != next) continue;
    commits[i].is_main = true;
    next = first_parents[i];
  }
  return commits;
}

void PlaceByCommits(const std::vector<history::Commit>& commits, HistoryFolder& folder) {
  Places places;
  for (std::size_t i = 0; i < commits.size(); ++i) places.emplace(commits[i].hash, i);
  std::erase_if(folder.files, [&](history::FileFigures& file) {
    const auto place = CommitIn(places, file.file);
    if (place && commits[*place].is_main) {
      file.place = static_cast<double>(*place);
      return false;
    }
    folder.left_out.push_back({file.file, place
                                              ? OfABranch(commits, *place)
                                              : "its name has no commit of the repository: name it "
                                                "BENCHMARK-COMMIT.h5"});
    return true;
  });
}

}  // namespace cdb::plans
