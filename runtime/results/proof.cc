#include "runtime/results/proof.h"

#include <fmt/format.h>

#include <string>
#include <system_error>

#include "runtime/results/files/limited_process.h"
#include "runtime/results/files/seal.h"
#include "runtime/results/hdf5/heaps.h"
#include "runtime/results/store.h"

namespace cdb::results {
namespace {

namespace fs = std::filesystem;

}  // namespace

files::WorkLimits LimitsForEveryValue(std::uint64_t bytes) {
  // The file may be mostly its plan: yaml-cpp takes 42 bytes for one of the text, and the plan has
  // as many again.
  constexpr std::uint64_t kPlanMemory = 80;
  files::WorkLimits limits = files::LimitsForFile(bytes);
  limits.memory_bytes += kPlanMemory * bytes;
  return limits;
}

bool ProveFile(const fs::path& path, std::string_view remedy, ProofOf of,
               const std::function<void(bool reads_values)>& read) {
  const files::SealState seal = files::CheckSeal(path);
  if (seal == files::SealState::kBroken)
    throw files::StoreError(
        fmt::format("{}: is damaged: its digest differs, so that some of its bytes are not as they "
                    "were written; it was left as it is: {}",
                    path.string(), remedy));
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(path, error);
  const bool reads_values =
      of == ProofOf::kEveryValue || (of == ProofOf::kFewValues && bytes <= kMostProven);
  const auto prove = [&] {
    if (reads_values) hdf5::CheckGlobalHeaps(path);
    read(reads_values);
  };
  const auto limits_for = of == ProofOf::kEveryValue ? LimitsForEveryValue : files::LimitsForFile;
  const std::string why = files::RunLimited(prove, limits_for(error ? 0 : bytes));
  if (why.empty()) return seal == files::SealState::kGood;
  if (why.starts_with(path.string() + ": ")) throw files::StoreError(why);
  throw files::StoreError(
      fmt::format("{}: is not a whole result of cdb: {}; it was left as it is: {}", path.string(),
                  why, remedy));
}

void RequireSeal(const hdf5::File& file, const fs::path& path) {
  if (!file.Text(kDigestAttribute).empty() && !files::IsSealed(path))
    throw hdf5::Error("its digest is missing, as its end was cut off or changed");
}

bool IsStored(const fs::path& path) { return hdf5::IsHdf5(path) || files::IsSealed(path); }

std::string ReadSchema(const fs::path& path) {
  if (std::error_code error; !fs::exists(path, error))
    throw files::StoreError(
        fmt::format("{}: there is no such file; `cdb run` makes one", path.string()));
  if (!hdf5::IsHdf5(path))
    throw files::StoreError(
        fmt::format("{}: is damaged: it ends as a file of cdb does, but does not begin as HDF5; it "
                    "was left as it is: restore a copy, or run it again",
                    path.string()));
  const auto read = [&] { return hdf5::File::Open(path).Text("schema"); };
  const std::string why = files::RunLimited([&] { read(); }, files::LimitsForFile(0));
  if (!why.empty())
    throw files::StoreError(
        fmt::format("{}: is damaged: {}; it was left as it is: restore a copy, or run "
                    "it again",
                    path.string(), why));
  return read();
}

}  // namespace cdb::results
