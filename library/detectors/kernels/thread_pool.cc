#include "library/detectors/kernels/thread_pool.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace cdb::kernels {
namespace {

/// About as long as it takes to wake a thread.
constexpr std::chrono::microseconds kSpinTime{60};
/// Shorter than the time that the system gives another program.
constexpr std::chrono::microseconds kInterruption{500};

void Pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

/// Waits for the condition for this time; true if it holds.
template <typename Condition>
bool SpinUntil(const Condition& condition, std::chrono::nanoseconds time = kSpinTime) {
  constexpr int kPauses = 32;
  const auto end = std::chrono::steady_clock::now() + time;
  do {
    for (int i = 0; i < kPauses; ++i) {
      if (condition()) return true;
      Pause();
    }
  } while (std::chrono::steady_clock::now() < end);
  return condition();
}

std::chrono::nanoseconds TimeOf(clockid_t clock) {
  timespec time;
  clock_gettime(clock, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

/// Increases while this thread sleeps or is interrupted.
std::chrono::nanoseconds LostTime() {
  return TimeOf(CLOCK_MONOTONIC) - TimeOf(CLOCK_THREAD_CPUTIME_ID);
}

// The parts of ThreadPool::next_.
constexpr int kCountShift = 16, kRoundShift = 32;
unsigned NextOf(std::uint64_t next) { return static_cast<unsigned>(next & 0xffff); }
unsigned CountOf(std::uint64_t next) { return static_cast<unsigned>(next >> kCountShift & 0xffff); }

}  // namespace

ThreadPool::Session::Session(ThreadPool& pool, bool wakes) : pool_(pool) {
  if (pool.threads_.empty() || pool.IsResting() || !(wakes || pool.IsAwake())) return;
  lost_ = LostTime();
  pool.stays_awake_ = true;
  pool.Wake();
}

ThreadPool::Session::~Session() {
  if (pool_.IsResting()) --pool_.rest_;
  if (!lost_) return;
  pool_.stays_awake_ = false;
  unsigned& next = pool_.next_rest_;
  if (LostTime() - *lost_ > kInterruption) {
    pool_.rest_ = next;
    next = std::min(2 * next, kLongestRest);
  } else {
    next = std::max(next - 1, kFirstRest);
  }
}

ThreadPool::ThreadPool(unsigned threads) {
  for (unsigned place = 1; place < threads; ++place) threads_.emplace_back([this] { Work(); });
}

ThreadPool::~ThreadPool() {
  is_over_ = true;
  ++calls_;
  calls_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

std::shared_ptr<ThreadPool> ThreadPool::Shared(unsigned threads) {
  thread_local std::weak_ptr<ThreadPool> last;
  std::shared_ptr<ThreadPool> pool = last.lock();
  if (pool == nullptr || pool->size() != threads)
    last = pool = std::make_shared<ThreadPool>(threads);
  return pool;
}

void ThreadPool::Wake() {
  if (sleeping_ == 0) return;
  ++calls_;
  calls_.notify_all();
}

void ThreadPool::Run(unsigned tasks, const std::function<void(unsigned)>& task) {
  if (threads_.empty() || IsResting())
    RunAlone(tasks, task);
  else
    RunShared(tasks, task);
  if (const std::exception_ptr error = std::exchange(error_, nullptr))
    std::rethrow_exception(error);
}

void ThreadPool::RunAlone(unsigned tasks, const std::function<void(unsigned)>& task) {
  for (unsigned index = 0; index < tasks; ++index) Execute(task, index);
}

void ThreadPool::RunShared(unsigned tasks, const std::function<void(unsigned)>& task) {
  const auto begin = std::chrono::steady_clock::now();
  task_ = &task;
  done_ = 0;
  const std::uint64_t round = (next_ >> kRoundShift) + 1;
  next_ = round << kRoundShift | std::uint64_t{tasks} << kCountShift;
  if (tasks > 1) Wake();
  while (ExecuteNext()) {
  }
  AwaitOthers(tasks, std::chrono::steady_clock::now() - begin);
}

/// Waits for the tasks that the other threads have begun. `own`: the time that the caller's tasks
/// took.
void ThreadPool::AwaitOthers(unsigned tasks, std::chrono::nanoseconds own) {
  constexpr int kMuchLonger = 2;
  if (SpinUntil([&] { return done_ == tasks; }, kSpinTime + kMuchLonger * own)) return;
  for (unsigned done = done_; done != tasks; done = done_) done_.wait(done);
}

bool ThreadPool::HasTasks() const {
  const std::uint64_t next = next_;
  return NextOf(next) < CountOf(next);
}

void ThreadPool::Execute(const std::function<void(unsigned)>& task, unsigned index) {
  try {
    task(index);
  } catch (...) {
    const std::lock_guard lock(error_mutex_);
    error_ = std::current_exception();
  }
}

/// Executes the next task; false if there is none.
bool ThreadPool::ExecuteNext() {
  std::uint64_t next = next_;
  const std::function<void(unsigned)>* task = nullptr;
  do {
    if (NextOf(next) == CountOf(next)) return false;
    task = task_;  // of this round, if next_ is unchanged
  } while (!next_.compare_exchange_weak(next, next + 1));
  Execute(*task, NextOf(next));
  if (++done_ == CountOf(next)) done_.notify_one();
  return true;
}

void ThreadPool::Work() {
  while (!is_over_) {
    if (ExecuteNext()) continue;
    const std::uint32_t calls = calls_;
    if (SpinUntil([&] { return HasTasks() || is_over_; }) || stays_awake_) continue;
    ++sleeping_;
    // A caller that saw nobody asleep made its tasks known before; one that sees this thread calls
    // it.
    if (!HasTasks()) calls_.wait(calls);
    --sleeping_;
  }
}

}  // namespace cdb::kernels
