#include "pagestore/read_queue.h"

#include <array>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <unordered_map>

#include "engine/check.h"

namespace atrium {

namespace {

class AdvisingQueue final : public ReadQueue {
 public:
  const std::string& name() const override { return name_; }

  void submit(DiskFile& file, std::uint64_t offset, std::span<std::byte> into,
              std::uint64_t ticket) override {
    file.will_read(offset, into.size());
    ATRIUM_CHECK(reads_.try_emplace(ticket, Read{&file, offset, into}).second);
  }

  Status wait(std::uint64_t ticket) override {
    const auto read = reads_.extract(ticket);
    ATRIUM_CHECK(!read.empty());
    return read.mapped().file->read_announced(read.mapped().offset, read.mapped().into);
  }

 private:
  struct Read {
    DiskFile* file;
    std::uint64_t offset;
    std::span<std::byte> into;
  };
  std::unordered_map<std::uint64_t, Read> reads_;
  std::string name_ = "advice";
};

// mutex_ guards all but the threads themselves; a Read is its thread's own between being taken from
// waiting_ and being done.
class ThreadQueue final : public ReadQueue {
 public:
  explicit ThreadQueue(const std::string& why) : name_("4 pread threads (" + why + ")") {
    static_assert(kThreads == 4, "the name says so");
    for (std::thread& thread : threads_) thread = std::thread([this] { serve(); });
  }

  ~ThreadQueue() override {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    work_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  const std::string& name() const override { return name_; }

  void submit(DiskFile& file, std::uint64_t offset, std::span<std::byte> into,
              std::uint64_t ticket) override {
    {
      const std::lock_guard lock(mutex_);
      const auto [read, added] = reads_.try_emplace(ticket, Read{&file, offset, into, {}, false});
      ATRIUM_CHECK(added);
      waiting_.push_back(&read->second);
    }
    work_.notify_one();
  }

  Status wait(std::uint64_t ticket) override {
    std::unique_lock lock(mutex_);
    const auto read = reads_.find(ticket);
    ATRIUM_CHECK(read != reads_.end());
    finished_.wait(lock, [&] { return read->second.done; });
    const Status result = read->second.result;
    reads_.erase(read);
    return result;
  }

 private:
  static constexpr std::size_t kThreads = 4;

  struct Read {
    DiskFile* file;
    std::uint64_t offset;
    std::span<std::byte> into;
    Status result;
    bool done;
  };

  void serve() {
    std::unique_lock lock(mutex_);
    for (;;) {
      work_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
      if (ending_) return;
      Read& read = *waiting_.front();
      waiting_.pop_front();
      lock.unlock();
      Status result = read.file->read(read.offset, read.into);
      lock.lock();
      read.result = std::move(result);
      read.done = true;
      finished_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable work_, finished_;
  std::unordered_map<std::uint64_t, Read> reads_;  // its elements stay where they are
  std::deque<Read*> waiting_;
  bool ending_ = false;
  std::string name_;
  std::array<std::thread, kThreads> threads_;
};

}  // namespace

std::unique_ptr<ReadQueue> make_advising_queue() { return std::make_unique<AdvisingQueue>(); }

std::unique_ptr<ReadQueue> make_thread_queue(const std::string& why) {
  return std::make_unique<ThreadQueue>(why);
}

}  // namespace atrium
