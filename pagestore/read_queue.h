// The ways reads get under way: queues behind Disk::read_queue.
#pragma once

#include <memory>

#include "engine/status.h"
#include "pagestore/disk.h"

namespace atrium {

// Advice at submit, the read itself at wait: for disks that have a cache to read ahead into, or
// nothing to gain from reading ahead.
std::unique_ptr<ReadQueue> make_advising_queue();

// io_uring, `depth` reads at a time in the kernel. For files of the direct disk. An error, and no
// queue, where the kernel or a sandbox refuses it.
Result<std::unique_ptr<ReadQueue>> make_uring_queue(unsigned depth);

// Four threads, each in one read at a time. For files whose read may be called from several
// threads at once. `why`: why not io_uring, for the name.
std::unique_ptr<ReadQueue> make_thread_queue(const std::string& why);

}  // namespace atrium
