// The program `cdb-import`: reads a file from standard input, in the format of the extension that
// is its argument, and writes its mesh as binary PLY to standard output. Exit status 1: the output
// is the cause and, on the next line, the remedy if there is one. library/meshes/import.h starts
// it, with limits.
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>

#include "library/confinement.h"
#include "library/meshes/importer/scene_mesh.h"
#include "library/scene_error.h"

namespace cdb::importer {
namespace {

std::string ReadInput() {
  std::string bytes(1 << 16, '\0');
  for (std::size_t size = 0;;) {
    const ssize_t count = read(STDIN_FILENO, bytes.data() + size, bytes.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      bytes.resize(size);
      return bytes;
    }
    size += static_cast<std::size_t>(count);
    if (size == bytes.size()) bytes.resize(2 * size);
  }
}

void Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

int Run(std::string_view extension) {
  try {
    Write(PlyOf(ReadInput(), extension));
    return 0;
  } catch (const library::SceneError& error) {
    Write(error.cause() + "\n" + error.remedy());
  } catch (const std::bad_alloc&) {
    Write("reading it takes more memory than such a file needs");
  } catch (const std::length_error&) {
    Write("reading it takes more memory than such a file needs");
  } catch (const std::exception& error) {
    Write(error.what());
  }
  return 1;
}

}  // namespace
}  // namespace cdb::importer

int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] != '.') {
    std::fprintf(stderr,
                 "cdb-import: this program imports a mesh for `cdb`; do not start it by hand\n");
    return 2;
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  cdb::library::Confine();
  _exit(cdb::importer::Run(argv[1]));  // without the destructors, which can crash as well
}
