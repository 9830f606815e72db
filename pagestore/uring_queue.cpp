// Reads by io_uring. A read goes from `waiting_` to the kernel, and from there to done, or back to
// the front of waiting_ where the kernel stopped short of its end.
//
// Invariants:
//  1. At most depth_ reads are with the kernel, so the rings never overflow.
//  2. The queue does not end while the kernel may still write into a caller's memory.
// Not thread safe.
#include <liburing.h>

#include <algorithm>
#include <deque>
#include <unordered_map>
#include <utility>

#include "engine/check.h"
#include "pagestore/direct_file.h"
#include "pagestore/read_queue.h"
#include "pagestore/record.h"

namespace atrium {

namespace {

// A request's length is 32 bits; a longer read goes on where the last one ended.
constexpr std::size_t kLongestRequest = std::size_t{1} << 30;

struct Read {
  DirectFile* file;
  std::uint64_t offset;       // of what is still to be read
  std::span<std::byte> left;  // where it goes
  Status result;
  bool done;
};

bool try_again(int error) { return error == EINTR || error == EAGAIN || error == EBUSY; }

class UringQueue final : public ReadQueue {
 public:
  UringQueue(const io_uring& ring, unsigned depth) : ring_(ring), depth_(depth) {}

  ~UringQueue() override {
    waiting_.clear();
    while (in_kernel_ > 0) take_completions();
    ::io_uring_queue_exit(&ring_);
  }

  const std::string& name() const override { return name_; }

  void submit(DiskFile& file, std::uint64_t offset, std::span<std::byte> into,
              std::uint64_t ticket) override {
    auto* direct = dynamic_cast<DirectFile*>(&file);
    ATRIUM_CHECK(direct != nullptr);
    const auto [read, added] = reads_.try_emplace(ticket, Read{direct, offset, into, {}, false});
    ATRIUM_CHECK(added);
    // What the kernel would refuse goes through the file's own bounce buffer, when it is waited
    // for.
    if (!DirectFile::aligned(offset, into)) return;
    waiting_.push_back(&read->second);
    take_what_is_done();
    hand_over();
  }

  Status wait(std::uint64_t ticket) override {
    const auto found = reads_.find(ticket);
    ATRIUM_CHECK(found != reads_.end());
    Read& read = found->second;
    if (!DirectFile::aligned(read.offset, read.left)) {
      read.result = read.file->read(read.offset, read.left);
      read.done = true;
    }
    while (!read.done) take_completions();
    const Status result = std::move(read.result);
    reads_.erase(found);
    return result;
  }

 private:
  // Those that the kernel has no room for now stay in the ring, and go with the next call.
  void hand_over() {
    if (waiting_.empty() || in_kernel_ == depth_) return;
    for (; !waiting_.empty() && in_kernel_ < depth_; ++in_kernel_) {
      Read& read = *waiting_.front();
      waiting_.pop_front();
      io_uring_sqe* request = ::io_uring_get_sqe(&ring_);
      ATRIUM_CHECK(request != nullptr);
      const auto bytes = static_cast<unsigned>(std::min(read.left.size(), kLongestRequest));
      ::io_uring_prep_read(request, read.file->descriptor(), read.left.data(), bytes, read.offset);
      ::io_uring_sqe_set_data(request, &read);
    }
    const int submitted = ::io_uring_submit(&ring_);
    ATRIUM_CHECK(submitted >= 0 || try_again(-submitted));
  }

  // Blocks where there is none yet, and lets those that waited take their places.
  void take_completions() {
    io_uring_cqe* completion = nullptr;
    if (::io_uring_peek_cqe(&ring_, &completion) != 0) {
      const int submitted = ::io_uring_submit_and_wait(&ring_, 1);
      ATRIUM_CHECK(submitted >= 0 || try_again(-submitted));
    }
    take_what_is_done();
    hand_over();
  }

  void take_what_is_done() {
    io_uring_cqe* completion = nullptr;
    while (::io_uring_peek_cqe(&ring_, &completion) == 0) {
      Read& read = *static_cast<Read*>(::io_uring_cqe_get_data(completion));
      const int outcome = completion->res;
      ::io_uring_cqe_seen(&ring_, completion);
      --in_kernel_;
      conclude(read, outcome);
    }
  }

  // outcome: bytes read, or minus an error.
  void conclude(Read& read, int outcome) {
    if (outcome < 0 && !try_again(-outcome)) return finish(read, failed(read, -outcome));
    const auto got = static_cast<std::size_t>(std::max(outcome, 0));
    if (got == read.left.size()) return finish(read, {});
    const std::size_t whole = got / kGranule * kGranule;
    if (outcome >= 0 && whole == 0)
      return finish(
          read, ends_early(read.file->path(), read.offset + got, read.offset + read.left.size()));
    read.offset += whole;
    read.left = read.left.subspan(whole);
    waiting_.push_front(&read);
  }

  static Status failed(const Read& read, int error) {
    return read.file->failed_read(read.offset, error);
  }
  static void finish(Read& read, Status result) {
    read.result = std::move(result);
    read.done = true;
  }

  io_uring ring_;
  unsigned depth_;
  unsigned in_kernel_ = 0;
  std::unordered_map<std::uint64_t, Read> reads_;  // its elements stay where they are
  std::deque<Read*> waiting_;
  std::string name_ = "io_uring";
};

}  // namespace

Result<std::unique_ptr<ReadQueue>> make_uring_queue(unsigned depth) {
  io_uring ring;
  const int made = ::io_uring_queue_init(depth, &ring, 0);
  if (made < 0) return failure("io_uring", "", "io_uring", -made);
  return std::unique_ptr<ReadQueue>(std::make_unique<UringQueue>(ring, depth));
}

}  // namespace atrium
