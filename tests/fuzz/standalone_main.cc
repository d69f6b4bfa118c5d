// Runs a fuzz target without a fuzzing engine: every file of a corpus, then mutations of them,
// which are the same on every machine. Link it with any *_fuzz.cc; with clang, link libFuzzer
// instead.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongest = 1 << 14;

using Engine = std::mt19937_64;

void RunOne(const std::string& input) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

std::vector<std::string> ReadCorpus(const fs::path& folder) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) paths.push_back(entry.path());
  // The order of files in a folder differs between machines.
  std::sort(paths.begin(), paths.end());
  std::vector<std::string> corpus;
  for (const fs::path& path : paths) {
    std::ifstream file(path, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return corpus;
}

std::string Mutate(const std::vector<std::string>& corpus, Engine& engine) {
  const auto below = [&](std::size_t count) { return count == 0 ? 0 : engine() % count; };
  std::string input = corpus[below(corpus.size())];
  for (std::size_t edits = 1 + below(8); edits > 0; --edits) {
    const std::string& other = corpus[below(corpus.size())];
    const std::size_t at = below(input.size() + 1);
    const std::size_t length = 1 + below(24);
    switch (below(6)) {
      case 0:  // remove a part
        input.erase(at, length);
        break;
      case 1:  // insert a part of another file
        input.insert(at, other, below(other.size() + 1), length);
        break;
      case 2:  // any byte
        input.insert(at, 1, static_cast<char>(below(256)));
        break;
      case 3:  // one bit
        if (at < input.size()) input[at] = static_cast<char>(input[at] ^ (1 << below(8)));
        break;
      case 4:  // the start of one file and the end of another
        input.resize(at);
        input.append(other, below(other.size() + 1), std::string::npos);
        break;
      default: {  // repeat a part many times
        const std::string piece = input.substr(at, length);
        for (std::size_t times = below(200); times > 0 && input.size() < kLongest; --times)
          input.insert(at, piece);
      }
    }
  }
  if (input.size() > kLongest) input.resize(kLongest);
  return input;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s CORPUS-FOLDER ITERATIONS\n", argv[0]);
    return 2;
  }
  try {
    const std::vector<std::string> corpus = ReadCorpus(argv[1]);
    if (corpus.empty()) {
      std::fprintf(stderr, "%s: no files in %s\n", argv[0], argv[1]);
      return 2;
    }
    for (const std::string& input : corpus) RunOne(input);
    const long iterations = std::strtol(argv[2], nullptr, 10);
    Engine engine(1);
    for (long i = 0; i < iterations; ++i) {
      const std::string input = Mutate(corpus, engine);
      // The input is left behind by a crash, so that it can be run alone.
      if (const char* keep = std::getenv("CDB_FUZZ_KEEP"))
        std::ofstream(keep, std::ios::binary) << input;
      RunOne(input);
    }
    std::printf("%zu files and %ld mutations\n", corpus.size(), iterations);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
  }
  return 0;
}
