#include "runtime/cli/publish/signature.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "compiler/plan/input_file.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/publish/digest.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/sweep/process/program.h"

namespace cdb::publish {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProgram = "ssh-keygen";
/// `SHA256:…`, in `Good "cdb-suite" signature with ED25519 key SHA256:…`; empty if there is none.
std::string FingerprintIn(const std::string& text) {
  const std::size_t begin = text.find("SHA256:");
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_first_of(" \n", begin) - begin);
}

/// The person to whom the keys of the folder above ascribe the signature; empty if it is none of
/// them, or not valid for this use now.
std::string SignerOf(const fs::path& signers, const fs::path& signature,
                     const std::string& digest) {
  const auto found = process::RunProgram(
      {kProgram, "-Y", "find-principals", "-f", signers.string(), "-s", signature.string()});
  if (!found || found->status != 0) return {};
  const std::string name = found->out.substr(0, found->out.find_first_of(",\n"));
  const auto verified = process::RunProgram({kProgram, "-Y", "verify", "-f", signers.string(), "-I",
                                             name, "-n", kNamespace, "-s", signature.string()},
                                            digest);
  return verified && verified->status == 0 ? name : std::string();
}

}  // namespace

void RequireKey(const std::string& key) {
  if (!process::FindProgram(kProgram))
    throw options::CommandError(
        "--sign needs the program ssh-keygen, which is in no folder of PATH; install it (as root "
        "`apt-get install openssh-client`), or leave out --sign and sign digest.txt by other "
        "means");
  if (const std::string why = plan::WhyNotReadable(key); !why.empty())
    throw options::CommandError(fmt::format(
        "--sign {}: {}; name a private key of ssh, or a public one whose private key ssh-agent "
        "holds",
        key, why));
}

Signature CheckSignature(const fs::path& folder) {
  const fs::path signature = fs::absolute(folder / kSignatureFile).lexically_normal();
  std::error_code error;
  if (!fs::exists(fs::symlink_status(signature, error))) return {.text = "not signed"};
  std::string why;
  const auto digest =
      plan::ReadInputFile((folder / kDigestFile).string(), why, process::kMostInput);
  if (!digest) return {SignatureState::kBad, "the signature is of no digest"};
  const auto checked = process::RunProgram(
      {kProgram, "-Y", "check-novalidate", "-n", kNamespace, "-s", signature.string()}, *digest);
  if (!checked)
    return {SignatureState::kUnchecked, "signed, but ssh-keygen is not installed, which checks it"};
  if (checked->status != 0) {
    // The author is not to blame for other failures, such as an ssh-keygen that is too old.
    const std::string cause = process::LastLine(checked->err);
    const bool is_verdict = why.find("ignature") != std::string::npos ||
                            why.find("parse") != std::string::npos ||
                            checked->out.find("Could not verify") != std::string::npos;
    if (is_verdict) return {SignatureState::kBad, "the signature does not match"};
    return {SignatureState::kUnchecked, "signed, but ssh-keygen cannot check it: " + cause};
  }
  const std::string key = FingerprintIn(checked->out);
  const fs::path signers = signature.parent_path().parent_path() / kSignersFile;
  if (!fs::exists(signers, error)) return {SignatureState::kGood, "signed by key " + key, key};
  if (const std::string name = SignerOf(signers, signature, *digest); !name.empty())
    return {SignatureState::kGood, fmt::format("signed by {}, key {}", name, key), key};
  return {SignatureState::kStranger,
          fmt::format("signed by key {}, which is not in {}", key, kSignersFile), key};
}

std::string FingerprintOf(const std::string& key) {
  RequireKey(key);
  const auto printed = process::RunProgram({kProgram, "-l", "-f", key});
  std::string fingerprint = printed ? FingerprintIn(printed->out) : std::string();
  if (fingerprint.empty())
    throw options::CommandError(fmt::format("--sign {}: it is not a key of ssh", key));
  return fingerprint;
}

void Sign(const fs::path& folder, const std::string& key) {
  RequireKey(key);
  std::string why;
  const auto digest =
      plan::ReadInputFile((folder / kDigestFile).string(), why, process::kMostInput);
  if (!digest)
    throw options::CommandError(fmt::format("{}: {}", (folder / kDigestFile).string(), why));
  const auto made = process::RunProgram({kProgram, "-q", "-Y", "sign", "-f", key, "-n", kNamespace},
                                        *digest, process::ProgramGroup::kCallers);
  if (!made || made->status != 0)
    throw options::CommandError(
        fmt::format("--sign {}: ssh-keygen cannot sign with it: {}", key,
                    made ? process::LastLine(made->err) : std::string("it was removed")));
  files::WriteWhole(made->out, folder / kSignatureFile);
}

}  // namespace cdb::publish
