#include "library/detectors/kernels/thread_pool.h"

#include <utility>

namespace cdb::kernels {
namespace {

/// Spins briefly until the condition holds, because waking a sleeping thread takes longer.
template <typename Condition>
void SpinUntil(const Condition& condition) {
  constexpr int kSpins = 400;
  for (int i = 0; i < kSpins && !condition(); ++i) {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
  }
}

}  // namespace

ThreadPool::ThreadPool(unsigned threads) {
  for (unsigned place = 1; place < threads; ++place)
    threads_.emplace_back([this, place] { Work(place); });
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  begin_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void ThreadPool::Run(const std::function<void(unsigned)>& part) {
  if (threads_.empty()) return part(0);
  {
    const std::lock_guard lock(mutex_);
    part_ = &part;
    working_ = size() - 1;
    ++round_;
  }
  begin_.notify_all();
  std::exception_ptr error;
  try {
    part(0);
  } catch (...) {
    error = std::current_exception();
  }
  SpinUntil([this] { return working_ == 0; });
  std::unique_lock lock(mutex_);
  end_.wait(lock, [this] { return working_ == 0; });
  std::exception_ptr theirs = std::exchange(error_, nullptr);
  if (error == nullptr) error = theirs;
  if (error != nullptr) std::rethrow_exception(error);
}

void ThreadPool::Work(unsigned place) {
  for (std::uint64_t done = 0;;) {
    SpinUntil([&] { return round_ != done; });
    std::unique_lock lock(mutex_);
    begin_.wait(lock, [&] { return is_over_ || round_ != done; });
    if (is_over_) return;
    done = round_;
    lock.unlock();
    std::exception_ptr error;
    try {
      (*part_)(place);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    if (error != nullptr) error_ = error;
    if (--working_ == 0) end_.notify_one();
  }
}

}  // namespace cdb::kernels
