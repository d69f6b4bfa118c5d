#include "compiler/plan/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <system_error>
#include <vector>

namespace cdb::plan {
namespace {

std::string ErrorText(int error) { return std::generic_category().message(error); }

std::string WhyNoFile(mode_t mode) {
  if (S_ISREG(mode)) return {};
  if (S_ISDIR(mode)) return "it is a folder";
  if (S_ISFIFO(mode)) return "it is a pipe, not a file";
  if (S_ISSOCK(mode)) return "it is a socket, not a file";
  return "it is a device, not a file";
}

/// The descriptor of a regular file, or -1 and the reason.
int OpenInput(const std::string& path, std::string& why) {
  struct stat status = {};
  // Checked before opening: opening alone rewinds a tape.
  if (stat(path.c_str(), &status) != 0) {
    why = ErrorText(errno);
    return -1;
  }
  if (why = WhyNoFile(status.st_mode); !why.empty()) return -1;
  const int fd = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (fd < 0) {
    why = ErrorText(errno);
    return -1;
  }
  why = fstat(fd, &status) != 0 ? ErrorText(errno) : WhyNoFile(status.st_mode);
  if (why.empty()) return fd;
  close(fd);
  return -1;
}

}  // namespace

std::string WhyNotReadable(const std::string& path) {
  std::string why;
  if (const int fd = OpenInput(path, why); fd >= 0) close(fd);
  return why;
}

std::optional<std::string> ReadInput(int fd, std::string& why, std::size_t max_bytes) {
  std::string bytes;
  char buffer[65536];
  for (;;) {
    const ssize_t count = read(fd, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      why = ErrorText(errno);
      return std::nullopt;
    }
    if (count == 0) return bytes;
    bytes.append(buffer, static_cast<std::size_t>(count));
    if (bytes.size() > max_bytes) {
      why = fmt::format("it has more than {} MiB", max_bytes >> 20);
      return std::nullopt;
    }
  }
}

std::optional<std::string> ReadInputFile(const std::string& path, std::string& why,
                                         std::size_t max_bytes) {
  const int fd = OpenInput(path, why);
  if (fd < 0) return std::nullopt;
  auto bytes = ReadInput(fd, why, max_bytes);
  close(fd);
  return bytes;
}

}  // namespace cdb::plan

#if defined(__x86_64__)
#include <cpuid.h>
#include <immintrin.h>
#endif

namespace cdb::plan {
namespace {

constexpr std::uint32_t kRound[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

using State = std::array<std::uint32_t, 8>;

void AddBlock(State& state, const unsigned char* block) {
  std::uint32_t w[64];
  for (int i = 0; i < 16; ++i)
    w[i] = std::uint32_t{block[4 * i]} << 24 | std::uint32_t{block[4 * i + 1]} << 16 |
           std::uint32_t{block[4 * i + 2]} << 8 | std::uint32_t{block[4 * i + 3]};
  for (int i = 16; i < 64; ++i) {
    const auto s0 = std::rotr(w[i - 15], 7) ^ std::rotr(w[i - 15], 18) ^ (w[i - 15] >> 3);
    const auto s1 = std::rotr(w[i - 2], 17) ^ std::rotr(w[i - 2], 19) ^ (w[i - 2] >> 10);
    w[i] = w[i - 16] + s0 + w[i - 7] + s1;
  }
  auto [a, b, c, d, e, f, g, h] = state;
  for (int i = 0; i < 64; ++i) {
    const auto s1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const auto t1 = h + s1 + ((e & f) ^ (~e & g)) + kRound[i] + w[i];
    const auto s0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    const auto t2 = s0 + ((a & b) ^ (a & c) ^ (b & c));
    h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
  }
  const State sum = {a, b, c, d, e, f, g, h};
  for (std::size_t i = 0; i < 8; ++i) state[i] += sum[i];
}

#if defined(__x86_64__)

bool HasShaInstructions() {
  unsigned a = 0, b = 0, c = 0, d = 0;
  constexpr unsigned kSsse3And41 = 1u << 9 | 1u << 19;  // SSSE3, SSE4.1
  if (__get_cpuid(1, &a, &b, &c, &d) == 0 || (c & kSsse3And41) != kSsse3And41) return false;
  return __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (b & 1u << 29) != 0;
}

/// The upper half of `a` and the lower half of `b`. (_mm_alignr_epi8 would do the same, but does
/// not compile with -O0 -flto.)
__m128i UpperThenLower(__m128i a, __m128i b) {
  return _mm_unpacklo_epi64(_mm_unpackhi_epi64(a, a), b);
}

/// AddBlock with the SHA instructions of x86, about six times as fast. Source: Intel, "Intel SHA
/// Extensions", 2013.
__attribute__((target("sha,sse4.1,ssse3"))) void AddBlockByInstructions(
    State& state, const unsigned char* block) {
  const __m128i order = _mm_set_epi64x(0x0c0d0e0f08090a0b, 0x0405060700010203);
  auto* words = reinterpret_cast<__m128i*>(state.data());
  __m128i low = _mm_shuffle_epi32(_mm_loadu_si128(words), 0xB1);       // c d a b
  __m128i high = _mm_shuffle_epi32(_mm_loadu_si128(words + 1), 0x1B);  // e f g h
  __m128i abef = UpperThenLower(high, low);
  __m128i cdgh = _mm_blend_epi16(high, low, 0xF0);
  const __m128i abef_before = abef, cdgh_before = cdgh;
  __m128i w[4];
  for (int i = 0; i < 4; ++i)
    w[i] = _mm_shuffle_epi8(_mm_loadu_si128(reinterpret_cast<const __m128i*>(block) + i), order);
  for (int i = 0; i < 16; ++i) {
    if (i >= 4) {
      // w[t] from w[t - 16], w[t - 15], w[t - 7], w[t - 2], four words at a time.
      const __m128i mixed = _mm_blend_epi16(w[(i + 2) % 4], w[(i + 3) % 4], 0x03);
      const __m128i seventh = _mm_shuffle_epi32(mixed, 0x39);
      w[i % 4] = _mm_sha256msg2_epu32(
          _mm_add_epi32(_mm_sha256msg1_epu32(w[i % 4], w[(i + 1) % 4]), seventh), w[(i + 3) % 4]);
    }
    const __m128i round =
        _mm_loadu_si128(reinterpret_cast<const __m128i*>(&kRound[4 * static_cast<std::size_t>(i)]));
    const __m128i sum = _mm_add_epi32(w[i % 4], round);
    cdgh = _mm_sha256rnds2_epu32(cdgh, abef, sum);
    abef = _mm_sha256rnds2_epu32(abef, cdgh, _mm_shuffle_epi32(sum, 0x0E));
  }
  abef = _mm_add_epi32(abef, abef_before);
  cdgh = _mm_add_epi32(cdgh, cdgh_before);
  low = _mm_shuffle_epi32(abef, 0x1B);   // f e b a
  high = _mm_shuffle_epi32(cdgh, 0xB1);  // d c h g
  _mm_storeu_si128(words, _mm_blend_epi16(low, high, 0xF0));
  _mm_storeu_si128(words + 1, UpperThenLower(low, high));
}

#endif

using Add = void (*)(State& state, const unsigned char* block);

Add FastestAdd() {
#if defined(__x86_64__)
  if (HasShaInstructions()) return AddBlockByInstructions;
#endif
  return AddBlock;
}

std::string HexOf(std::string_view data, Add add) {
  State state = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  const auto* bytes = reinterpret_cast<const unsigned char*>(data.data());
  std::size_t left = data.size();
  for (; left >= 64; left -= 64, bytes += 64) add(state, bytes);
  std::vector<unsigned char> tail(bytes, bytes + left);
  tail.push_back(0x80);
  while (tail.size() % 64 != 56) tail.push_back(0);
  const std::uint64_t bits = std::uint64_t{data.size()} * 8;
  for (int shift = 56; shift >= 0; shift -= 8)
    tail.push_back(static_cast<unsigned char>(bits >> shift));
  for (std::size_t i = 0; i < tail.size(); i += 64) add(state, tail.data() + i);
  std::string hex;
  for (const std::uint32_t word : state)
    for (int shift = 28; shift >= 0; shift -= 4) hex += "0123456789abcdef"[word >> shift & 15];
  return hex;
}

}  // namespace

std::string Sha256Hex(std::string_view data) {
  static const Add kAdd = FastestAdd();
  return HexOf(data, kAdd);
}

std::string PortableSha256Hex(std::string_view data) { return HexOf(data, AddBlock); }

}  // namespace cdb::plan
