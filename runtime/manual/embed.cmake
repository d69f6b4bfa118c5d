# Writes the Markdown files of this folder as a C++ source: cmake -DOUT=pages.cc -P embed.cmake
file(GLOB pages ${CMAKE_CURRENT_LIST_DIR}/*.md)
list(SORT pages)
set(rows)
foreach(page IN LISTS pages)
  cmake_path(GET page STEM name)
  file(READ ${page} text)
  string(APPEND rows "    {\"${name}\", R\"page(${text})page\"},\n")
endforeach()
file(WRITE ${OUT} "#include \"runtime/manual/page.h\"\n\nnamespace cdb::manual {\nnamespace {\n\n"
  "constexpr Page kPages[] = {\n${rows}};\n\n}  // namespace\n\n"
  "std::span<const Page> Pages() { return kPages; }\n\n}  // namespace cdb::manual\n")
