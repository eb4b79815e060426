// Fork and join, to build the two subtrees of a large node in parallel.
//
// The thread that forked a task takes it back if no other thread has started it; otherwise it runs other tasks until
// that one is done. The result of a task does not depend on the thread that runs it.
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
#include "start_threads.hpp"

namespace fastlines {

class TaskGroup {
 public:
  explicit TaskGroup(unsigned n_threads) {
    if (n_threads > 1) threads_ = start_threads(n_threads - 1, [this] { serve(); });
  }

  ~TaskGroup() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  TaskGroup(const TaskGroup&) = delete;
  TaskGroup& operator=(const TaskGroup&) = delete;

  /// Whether the group has more than one thread.
  bool is_parallel() const { return !threads_.empty(); }

  /// Keeps the first error. Ignores Cancelled, which only follows from another error or from a request of the watcher.
  void keep_error(std::exception_ptr error) {
    try {
      std::rethrow_exception(error);
    } catch (const Cancelled&) {
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!error_) error_ = error;
    }
  }
  /// Throws the error that `keep_error` kept, if there is one.
  void rethrow() {
    const std::lock_guard lock(mutex_);
    if (error_) std::rethrow_exception(error_);
  }

  /// Runs `mine` while another thread may run `theirs`. Returns false if no other thread has: the caller then has to
  /// run it. An exception of either is thrown only after both have ended.
  template <class Mine, class Theirs>
  bool fork_join(Mine&& mine, Theirs&& theirs) {
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

  /// Calls work(begin, end) for ranges that divide [first, end), each of at least min_size unless the whole is smaller.
  template <class Work>
  void for_ranges(std::size_t first, std::size_t end, std::size_t min_size, Work&& work) {
    if (!is_parallel() || end - first < 2 * min_size) return work(first, end);
    const std::size_t middle = first + (end - first) / 2;
    const auto rest = [&] { for_ranges(middle, end, min_size, work); };
    if (!fork_join([&] { for_ranges(first, middle, min_size, work); }, rest)) rest();
  }

 private:
  /// A function to run. The address of the task must stay valid until the task is taken back or joined.
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

  /// Removes a task that no thread has started. Returns false if one has.
  bool take_back(Task& task) {
    const std::lock_guard lock(mutex_);
    const auto place = std::find(waiting_.begin(), waiting_.end(), &task);
    if (place == waiting_.end()) return false;
    waiting_.erase(place);
    return true;
  }

  /// Waits for a task that another thread has started, and runs other tasks meanwhile. Rethrows the task's exception.
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

  /// Runs the task that has waited longest, which is the largest. `lock` is released meanwhile.
  void run_oldest(std::unique_lock<std::mutex>& lock) {
    Task& task = *waiting_.front();
    waiting_.pop_front();
    lock.unlock();
    task.run();
    lock.lock();
    changed_.notify_all();
  }

  /// Runs tasks until the group is destroyed.
  void serve() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
      if (stopping_) return;
      run_oldest(lock);
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task*> waiting_;
  std::vector<std::thread> threads_;
  std::exception_ptr error_;
  bool stopping_ = false;
};

}  // namespace fastlines
