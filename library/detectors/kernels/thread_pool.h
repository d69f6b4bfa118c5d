// A small pool of threads that share the tasks of one loop.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace cdb::kernels {

/// `threads` threads including the caller's. Each takes the next task that nobody has taken, so
/// that the caller waits only for tasks that are being executed, never for a thread to wake up,
/// which takes some 60 us on a virtual machine. The others sleep if there is no task for that time,
/// except during a Session. They end with the pool.
///
/// If the system interrupts the caller, or a task that it waits for, because other programs need
/// the processors, that takes milliseconds. The caller then works alone in the next sessions: the
/// more of them, the more often it happens. Errors: Run rethrows the exception of a task, after all
/// tasks. Threads: one caller.
class ThreadPool {
 public:
  explicit ThreadPool(unsigned threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// The calling thread's pool of this size, shared by the phases of a cycle, so that threads stay
  /// awake between them.
  static std::shared_ptr<ThreadPool> Shared(unsigned threads);

  unsigned size() const { return static_cast<unsigned>(threads_.size()) + 1; }
  /// True if another thread is awake and would take a task at once.
  bool IsAwake() const { return !IsResting() && sleeping_ < threads_.size(); }
  /// True if the caller works alone for now.
  bool IsResting() const { return rest_ > 0; }
  /// A cycle of loops. The other threads stay awake during it if they are awake, or if it `wakes`
  /// them, which does not wait for them.
  class Session {
   public:
    Session(ThreadPool& pool, bool wakes);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

   private:
    ThreadPool& pool_;
    std::optional<std::chrono::nanoseconds> lost_;  ///< LostTime before it, if threads stay awake
  };
  /// Calls task(0) to task(tasks - 1), at most kMostTasks, each once and on any thread. Returns
  /// when all are done. Threads that are asleep are woken.
  void Run(unsigned tasks, const std::function<void(unsigned)>& task);
  static constexpr unsigned kMostTasks = 0xffff;

 private:
  static constexpr unsigned kFirstRest = 64, kLongestRest = 1 << 14;

  void Wake();
  void AwaitOthers(unsigned tasks, std::chrono::nanoseconds own);
  bool HasTasks() const;
  void Execute(const std::function<void(unsigned)>& task, unsigned index);
  bool ExecuteNext();
  void RunAlone(unsigned tasks, const std::function<void(unsigned)>& task);
  void RunShared(unsigned tasks, const std::function<void(unsigned)>& task);
  void Work();

  /// The round, the number of its tasks and the next one of them, in one number, so that no thread
  /// takes a task of a round that has ended.
  std::atomic<std::uint64_t> next_ = 0;
  std::atomic<const std::function<void(unsigned)>*> task_ = nullptr;  ///< set before next_
  std::atomic<unsigned> done_ = 0;
  std::atomic<std::uint32_t> calls_ = 0;  ///< to wake up; sleeping threads wait for a change
  std::atomic<std::size_t> sleeping_ = 0;
  std::atomic<bool> stays_awake_ = false, is_over_ = false;
  std::mutex error_mutex_;
  std::exception_ptr error_;
  unsigned rest_ = 0;  ///< sessions in which the other threads are not used
  unsigned next_rest_ = kFirstRest;
  std::vector<std::thread> threads_;
};

}  // namespace cdb::kernels
