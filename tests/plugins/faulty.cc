// Detectors that each fail in a different way after their library is loaded.
#include <signal.h>
#include <unistd.h>
#ifdef __x86_64__
#include <xmmintrin.h>
#endif

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "library/detectors/detector.h"
#include "tests/plugins/every_pair.h"

namespace {

using namespace cdb;

/// Changes the floating-point environment, as the initializers of a library linked with -ffast-math
/// do, and worse: all later arithmetic rounds upwards.
const int kRoundsUpFromTheStart = std::fesetround(FE_UPWARD);

[[noreturn]] void Throw() { throw std::runtime_error("out of luck"); }

/// Lists every pair, and one contact for each; derived classes add their fault.
class Sound : public EveryPair {
 public:
  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    for (const Pair& pair : pairs) {
      const Vec3 &a = scene.poses[pair.a].position, &b = scene.poses[pair.b].position;
      contacts.push_back({pair.a, pair.b, a, b, {0, 1, 0}, -1e-3});
    }
  }
};

struct ThrowsInMake : Sound {
  ThrowsInMake() { Throw(); }
};
struct ThrowsInPrepare : Sound {
  void Prepare(const Scene&) override { Throw(); }
};
struct ThrowsInFindPairs : Sound {
  void FindPairs(const Scene&, std::vector<Pair>&) override { Throw(); }
};
struct ThrowsANumber : Sound {
  void FindPairs(const Scene&, std::vector<Pair>&) override { throw 42; }
};
struct ThrowsEscapes : Sound {
  void FindPairs(const Scene&, std::vector<Pair>&) override {
    throw std::runtime_error("all \x1b[32mwell\n\xff\u202e of it");
  }
};
struct RoundsUp : Sound {
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    Sound::FindPairs(scene, pairs);
    std::fesetround(FE_UPWARD);
  }
};
#ifdef __x86_64__
struct FlushesDenormals : Sound {
  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    Sound::FindContacts(scene, pairs, contacts);
    _mm_setcsr(_mm_getcsr() | 0x8040);
  }
};
#endif
struct ThrowsInFindContacts : Sound {
  void FindContacts(const Scene&, std::span<const Pair>, std::vector<Contact>&) override {
    Throw();
  }
};
struct Aborts : Sound {
  void FindPairs(const Scene&, std::vector<Pair>&) override { std::abort(); }
};
struct Segfaults : Sound {
  void FindPairs(const Scene&, std::vector<Pair>&) override { raise(SIGSEGV); }
};
struct Hangs : Sound {
  void FindPairs(const Scene&, std::vector<Pair>&) override {
    for (;;) pause();
  }
};
struct Naps : Sound {
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    Sound::FindPairs(scene, pairs);
    usleep(2000);
  }
};
/// The higher body first.
struct Backwards : Sound {
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    Sound::FindPairs(scene, pairs);
    for (Pair& pair : pairs) pair = {pair.b, pair.a};
  }
};
struct UnknownBody : Sound {
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    pairs.push_back({0, static_cast<Id>(scene.size)});
  }
};
struct SameBody : Sound {
  void FindPairs(const Scene&, std::vector<Pair>& pairs) override { pairs.push_back({1, 1}); }
};

/// Changes the contacts.
template <typename Change>
class Spoiled : public Sound {
 public:
  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    Sound::FindContacts(scene, pairs, contacts);
    std::ranges::for_each(contacts, Change());
  }
};
struct PlaceIsNaN {
  void operator()(Contact& contact) const {
    contact.on_a.x = std::numeric_limits<double>::quiet_NaN();
  }
};
struct DistanceIsNaN {
  void operator()(Contact& contact) const { contact.distance = std::nan(""); }
};
struct LongNormal {
  void operator()(Contact& contact) const { contact.normal = {0, 2, 0}; }
};

/// Finds no contact.
struct IsBlind : EveryPair {};

template <typename T>
Detector* Make(const Options&) {
  return new T;
}
Detector* MakeNothing(const Options&) { return nullptr; }

constexpr DetectorEntry kEntries[] = {
    {"sound", "does what it should", kBroad, 0, Make<Sound>},
    {"few", "holds ten bodies", kBroad, 10, Make<Sound>},
    {"makes_nothing", "", kBroad, 0, MakeNothing},
    {"throws_in_make", "", kBroad, 0, Make<ThrowsInMake>},
    {"throws_in_prepare", "", kBroad, 0, Make<ThrowsInPrepare>},
    {"throws_in_find_pairs", "", kBroad, 0, Make<ThrowsInFindPairs>},
    {"throws_a_number", "", kBroad, 0, Make<ThrowsANumber>},
    {"throws_escapes", "", kBroad, 0, Make<ThrowsEscapes>},
    {"rounds_up", "", kBroad, 0, Make<RoundsUp>},
#ifdef __x86_64__
    {"flushes_denormals", "", kNarrow, 0, Make<FlushesDenormals>},
#endif
    {"aborts", "", kBroad, 0, Make<Aborts>},
    {"segfaults", "", kBroad, 0, Make<Segfaults>},
    {"hangs", "", kBroad, 0, Make<Hangs>},
    {"naps", "", kBroad, 0, Make<Naps>},
    {"backwards", "", kBroad, 0, Make<Backwards>},
    {"unknown_body", "", kBroad, 0, Make<UnknownBody>},
    {"same_body", "", kBroad, 0, Make<SameBody>},
    {"throws_in_find_contacts", "", kNarrow, 0, Make<ThrowsInFindContacts>},
    {"is_blind", "", kNarrow, 0, Make<IsBlind>},
    {"place_is_nan", "", kNarrow, 0, Make<Spoiled<PlaceIsNaN>>},
    {"distance_is_nan", "", kNarrow, 0, Make<Spoiled<DistanceIsNaN>>},
    {"long_normal", "", kNarrow, 0, Make<Spoiled<LongNormal>>},
};

}  // namespace

CDB_DETECTORS(kEntries)
