// Any bytes as an entry of the cache. A damaged entry is treated as missing. Contents with the
// right digest give hulls whose faces refer to their vertices, or the hulls are computed again.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "dsl/text/check.h"
#include "library/content_cache.h"
#include "library/objects/solid_factory.h"
#include "tests/support/files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cdb;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const tests::TemporaryFolder folder;
  const std::string key = objects::DecompositionKey("source");
  const auto read = [&] {
    const objects::ConvexDecomposition form = objects::DecomposeOnce(
        "name", "source",
        [] {
          objects::ConvexDecomposition made;
          made.proportions.setOnes();
          made.pieces.emplace_back();
          made.pieces[0].centre.setZero();
          made.pieces[0].half.setOnes();
          return made;
        },
        folder.path());
    CDB_CHECK(form.name == "name" && !form.pieces.empty());
    for (const objects::ConvexPiece& piece : form.pieces)
      for (const meshes::Triangle& face : piece.faces)
        for (const std::uint32_t vertex : face) CDB_CHECK(vertex < piece.vertices.size());
  };
  library::StoreCached(folder.path(), "form", key, bytes);
  read();
  for (const std::string& name : tests::FilesIn(folder.path()))
    tests::WriteFile(folder / name, std::string(bytes));
  CDB_CHECK(!library::FindCached(folder.path(), "form", key) || size > 64);
  read();
  return 0;
}
