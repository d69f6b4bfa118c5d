#include "runtime/engine/worker/memory_shortage.h"

#include <LinearMath/btAlignedAllocator.h>

#include <cstdint>
#include <cstdlib>
#include <new>

namespace cdb::worker {
namespace {

/// Global, because a new handler has no argument; null without a NotesMemoryShortage.
std::atomic<std::uint32_t>* noted_in = nullptr;

[[noreturn]] void NoteShortage() {
  if (noted_in != nullptr) noted_in->store(1, std::memory_order_relaxed);
  throw std::bad_alloc();
}

void* Allocate(std::size_t bytes) {
  void* memory = std::malloc(bytes);
  if (memory == nullptr) NoteShortage();
  return memory;
}

}  // namespace

NotesMemoryShortage::NotesMemoryShortage(std::atomic<std::uint32_t>& place) {
  noted_in = &place;
  std::set_new_handler(NoteShortage);
  btAlignedAllocSetCustom(Allocate, std::free);
}

NotesMemoryShortage::~NotesMemoryShortage() {
  btAlignedAllocSetCustom(nullptr, nullptr);
  std::set_new_handler(nullptr);
  noted_in = nullptr;
}

}  // namespace cdb::worker
