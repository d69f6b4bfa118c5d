// A small pool of threads that execute the parts of one loop.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace cdb::kernels {

/// `threads` threads including the caller's. Between two calls of Run the others spin for some
/// microseconds, because the loops of one cycle follow each other closely, and then sleep. They end
/// with the pool. Errors: Run rethrows the exception of a part, that of the caller's part first.
/// Threads: one caller.
class ThreadPool {
 public:
  explicit ThreadPool(unsigned threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  unsigned size() const { return static_cast<unsigned>(threads_.size()) + 1; }
  /// Calls part(0) to part(size() - 1), each on a different thread, and waits for all.
  void Run(const std::function<void(unsigned)>& part);

 private:
  void Work(unsigned place);

  std::mutex mutex_;
  std::condition_variable begin_, end_;
  const std::function<void(unsigned)>* part_ = nullptr;
  std::atomic<std::uint64_t> round_ = 0;  ///< changed with mutex_ held, as is working_
  std::atomic<unsigned> working_ = 0;
  bool is_over_ = false;
  std::exception_ptr error_;
  std::vector<std::thread> threads_;
};

}  // namespace cdb::kernels
