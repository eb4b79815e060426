// Fork and join: the two subtrees of a large node are built side by side.
//
// Whoever offered a task takes it back if nobody has begun it, and else helps with others until it is done. What a task
// makes does not depend on who does it.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <vector>

#include "progress.hpp"
#include "thread_pool.hpp"

namespace fastlines {

class TaskGroup {
 public:
  explicit TaskGroup(unsigned n_threads) {
    if (n_threads > 1) threads_ = start_threads(n_threads - 1, [this] { serve(); });
  }

  ~TaskGroup() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  TaskGroup(const TaskGroup&) = delete;
  TaskGroup& operator=(const TaskGroup&) = delete;

  /// Whether anybody is there to share work with.
  bool shared() const { return !threads_.empty(); }

  /// Keep the first error that is more than a consequence of another.
  void note(std::exception_ptr error) {
    try {
      std::rethrow_exception(error);
    } catch (const Cancelled&) {
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!error_) error_ = error;
    }
  }
  void rethrow() {
    const std::lock_guard lock(mutex_);
    if (error_) std::rethrow_exception(error_);
  }

  /// Do `mine`, while somebody may take `theirs`. Returns whether that is done too; else it is still to be done. Both
  /// are over before what either throws is thrown on.
  template <class Mine, class Theirs>
  bool side_by_side(Mine&& mine, Theirs&& theirs) {
    Task task(theirs);
    fork(task);
    try {
      mine();
    } catch (...) {
      try {
        if (!take_back(task)) join(task);
      } catch (...) {
      }
      throw;
    }
    if (take_back(task)) return false;
    join(task);
    return true;
  }

  /// Call work(first, end) for parts of [first, end), none much smaller than `least`.
  template <class Work>
  void in_parts(std::size_t first, std::size_t end, std::size_t least, Work&& work) {
    if (!shared() || end - first < 2 * least) return work(first, end);
    const std::size_t middle = first + (end - first) / 2;
    const auto rest = [&] { in_parts(middle, end, least, work); };
    if (!side_by_side([&] { in_parts(first, middle, least, work); }, rest)) rest();
  }

 private:
  /// Something to do. It stays where it is until it has been joined.
  class Task {
   public:
    explicit Task(std::function<void()> work) : work_(std::move(work)) {}

   private:
    friend class TaskGroup;
    void run() {
      try {
        work_();
      } catch (...) {
        error_ = std::current_exception();
      }
      done_.store(true, std::memory_order_release);
    }
    std::function<void()> work_;
    std::exception_ptr error_;
    std::atomic<bool> done_{false};
  };

  void fork(Task& task) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(&task);
    }
    changed_.notify_one();
  }

  /// Whether nobody had begun it.
  bool take_back(Task& task) {
    const std::lock_guard lock(mutex_);
    const auto mine = std::find(waiting_.begin(), waiting_.end(), &task);
    if (mine == waiting_.end()) return false;
    waiting_.erase(mine);
    return true;
  }

  /// Wait until a task that somebody has begun is done; throws what it threw.
  void join(Task& task) {
    std::unique_lock lock(mutex_);
    while (!task.done_.load(std::memory_order_acquire)) {
      if (waiting_.empty())
        changed_.wait(lock);
      else
        run_oldest(lock);
    }
    if (task.error_) std::rethrow_exception(task.error_);
  }

  /// The oldest is the largest.
  void run_oldest(std::unique_lock<std::mutex>& lock) {
    Task& task = *waiting_.front();
    waiting_.pop_front();
    lock.unlock();
    task.run();
    lock.lock();
    changed_.notify_all();
  }

  void serve() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return over_ || !waiting_.empty(); });
      if (over_) return;
      run_oldest(lock);
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task*> waiting_;
  std::vector<std::thread> threads_;
  std::exception_ptr error_;
  bool over_ = false;
};

}  // namespace fastlines
