#include "runtime/cli/publish/digest.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <system_error>

#include "compiler/plan/input_file.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/suite_plan.h"
#include "runtime/sweep/process/program.h"

namespace cdb::publish {
namespace {

namespace fs = std::filesystem;

/// A digest must be small enough to be signed.
constexpr std::size_t kMostDigestBytes = process::kMostInput;
constexpr std::size_t kHexDigits = 64;
/// Two of a million folders share so many with a probability below 1 %.
constexpr std::size_t kWordDigits = 12;

bool IsHex(std::string_view text) {
  return text.size() == kHexDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

/// Nullopt if a line is not one of `sha256sum`, or names a file of another folder.
std::optional<Digest> ParseDigest(const std::string& text) {
  Digest digest;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.size() <= kHexDigits + 2 || line.substr(kHexDigits, 2) != "  ") return std::nullopt;
    const std::string hex = line.substr(0, kHexDigits), name = line.substr(kHexDigits + 2);
    if (!IsHex(hex) || name.find('/') != std::string::npos) return std::nullopt;
    if (!digest.emplace(name, hex).second) return std::nullopt;
  }
  return digest;
}

/// The names in the folder, in order, without those of the digest and its signature.
std::vector<std::string> NamesIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (std::string name = entry->path().filename().string();
        name != kDigestFile && name != kSignatureFile)
      names.push_back(std::move(name));
  if (error)
    throw options::CommandError(
        fmt::format("cannot read the folder '{}': {}", folder.string(), error.message()));
  std::ranges::sort(names);
  return names;
}

/// A link could name a file outside of the folder.
bool IsPlainFile(const fs::path& file) {
  std::error_code error;
  return fs::symlink_status(file, error).type() == fs::file_type::regular;
}

}  // namespace

Digest ComputeDigest(const fs::path& folder) {
  Digest digest;
  for (const std::string& name : NamesIn(folder)) digest[name] = plans::FileSha256(folder / name);
  return digest;
}

Digest ReadDigest(const fs::path& folder) {
  std::string why;
  const auto text = plan::ReadInputFile((folder / kDigestFile).string(), why, kMostDigestBytes);
  return text ? ParseDigest(*text).value_or(Digest()) : Digest();
}

std::string DigestText(const Digest& digest) {
  std::string text;
  for (const auto& [name, hex] : digest) text += fmt::format("{}  {}\n", hex, name);
  return text;
}

std::string ResultsWord(const Digest& digest) {
  Digest results;
  for (const auto& [name, hex] : digest)
    if (name.ends_with(".h5")) results[name] = hex;
  return plan::Sha256Hex(DigestText(results)).substr(0, kWordDigits);
}

std::vector<std::string> FindDigestFaults(const fs::path& folder) {
  std::string why;
  const auto text = plan::ReadInputFile((folder / kDigestFile).string(), why, kMostDigestBytes);
  if (!text || !IsPlainFile(folder / kDigestFile))
    return {fmt::format("{}: {}; `cdb suite --publish` writes it", kDigestFile,
                        text ? "it is a link" : why)};
  const auto digest = ParseDigest(*text);
  if (!digest) return {fmt::format("{}: it is not a list as `sha256sum` prints it", kDigestFile)};
  std::vector<std::string> faults;
  const std::vector<std::string> names = NamesIn(folder);
  for (const std::string& name : names) {
    const auto of = digest->find(name);
    if (of == digest->end())
      faults.push_back(fmt::format("{}: it is not in {}", name, kDigestFile));
    else if (!IsPlainFile(folder / name))
      faults.push_back(fmt::format("{}: it is not a regular file", name));
    else if (plans::FileSha256(folder / name) != of->second)
      faults.push_back(fmt::format("{}: it has changed since {} was written", name, kDigestFile));
  }
  for (const auto& [name, hex] : *digest)
    if (!std::ranges::binary_search(names, name))
      faults.push_back(fmt::format("{}: it is missing", name));
  return faults;
}

}  // namespace cdb::publish
