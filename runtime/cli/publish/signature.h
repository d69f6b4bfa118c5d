// Signatures of digests by SSH keys, which many people have: made and verified by `ssh-keygen -Y`.
//
// A signature holds the public key that verifies it. Whose key that is can be read from
// `allowed_signers`, a file of ssh-keygen beside the published folders; without it, a reader
// compares fingerprints.
//
// Threads: one.
#pragma once

#include <filesystem>
#include <string>

namespace cdb::publish {

/// Keeps these signatures apart from others by the same key.
inline constexpr const char* kNamespace = "cdb-suite";
inline constexpr const char* kSignersFile = "allowed_signers";

enum class SignatureState {
  kNone,       ///< there is no signature
  kGood,       ///< by a signer that is known, if there are known ones
  kStranger,   ///< by a key that is not in `allowed_signers`
  kBad,        ///< not of this digest, or not a signature
  kUnchecked,  ///< ssh-keygen is not installed, or cannot check it
};

struct Signature {
  SignatureState state = SignatureState::kNone;
  std::string text = {};         ///< `signed by ann@example.org, key SHA256:…`
  std::string fingerprint = {};  ///< `SHA256:…`; empty if there is no signature that matches
};

/// Verifies the signature of the digest in `folder`.
Signature CheckSignature(const std::filesystem::path& folder);

/// Throws CommandError if ssh-keygen is not installed, or the file of a key cannot be read.
void RequireKey(const std::string& key);

/// `SHA256:…`. Throws CommandError if it is not a key, or ssh-keygen is not installed.
std::string FingerprintOf(const std::string& key);

/// Signs the digest in `folder` with a private key, or with a public key whose private one
/// ssh-agent holds. May ask for a passphrase. Replaces a signature. Throws CommandError, with
/// nothing changed.
void Sign(const std::filesystem::path& folder, const std::string& key);

}  // namespace cdb::publish
