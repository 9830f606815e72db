// PageFile: the store's extents on disk, in a row of segment files `pages.0000`, `pages.0001`, …
// A segment is reserved whole before anything is written to it, so that a full disk is an error
// here and not a signal later; segments grow with the store, from 1 MiB doubling to 256 MiB, so
// that a small store is small. An extent lies in one segment.
//
// A granule's states, and what may be trusted in it (FORMAT.md):
//
//            allocate            root e durable          rewritten            root e+2 durable
//     free ───────────▶ claimed ───────────────▶ committed ─────────▶ retired ───────────────▶ free
//       ▲                  │ free: no root ever named it   in epoch e+1, still named by root e
//       └──────────────────┘
//
//     free       nothing: old records, zeros, halves of writes.
//     claimed    nothing after a crash: no root names it. This process reads back what it wrote.
//     committed  everything: named by the newest root, synced before that root was written. Never
//                changed in place.
//     retired    everything, as long as the older root stands: it is what recovery falls back on.
//
// Invariants:
//  1. Only free granules are written.
//  2. What is retired in the epoch that root e+1 will close is free once root e+2 is durable: by
//     then neither slot names it.
// Not thread safe.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/status.h"
#include "pagestore/disk.h"
#include "pagestore/extent.h"

namespace atrium {

class PageFile {
 public:
  // Finds the segments that are there; every granule counts as free until it is taken.
  static Result<std::unique_ptr<PageFile>> open(Disk& disk, const std::string& dir,
                                                DiskAccess access);

  Result<std::uint64_t> allocate(std::uint64_t granules);
  void free(std::uint64_t first, std::uint64_t granules) { holes_.free(first, granules); }
  void retire(std::uint64_t first, std::uint64_t granules) {
    retired_now_.emplace_back(first, granules);
  }
  void root_is_durable();

  // Opening: the extents that roots name. `take` is false where one is not free or not there.
  bool take(std::uint64_t first, std::uint64_t granules) { return holes_.take(first, granules); }
  void retired_before(std::uint64_t first, std::uint64_t granules) {
    retired_before_.emplace_back(first, granules);
  }
  void forget_what_is_taken();

  Status write(std::uint64_t first, std::span<const std::byte> image);
  Status read(std::uint64_t first, std::span<std::byte> image, Known known);
  // Gets a read under way, to be waited for by its ticket; `queue` is of the same disk.
  Status queue_read(ReadQueue& queue, std::uint64_t first, std::span<std::byte> image,
                    std::uint64_t ticket);
  Status sync();  // everything written so far is durable on return

  std::uint64_t file_bytes() const;
  // Of the files that so many bytes of extents end up in.
  static std::uint64_t file_bytes_for(std::uint64_t bytes);
  std::uint64_t free_granules() const { return holes_.free_granules(); }

  // For errors: the file an address lies in, and "byte n".
  std::string path_of(std::uint64_t first) const;
  static std::string place_of(std::uint64_t first);

 private:
  struct Segment {
    std::unique_ptr<DiskFile> file;
    std::uint64_t granules = 0;
    bool unsynced = false;
  };
  using Run = std::pair<std::uint64_t, std::uint64_t>;  // first, granules

  PageFile(Disk& disk, std::string dir) : disk_(disk), dir_(std::move(dir)) {}
  std::string segment_path(std::size_t segment) const;
  Result<DiskFile*> file_of(std::uint64_t first);
  Status adopt_segments(DiskAccess access);
  Status grow(std::uint64_t granules);
  Status add_segment(std::uint64_t granules);

  Disk& disk_;
  std::string dir_;
  std::vector<Segment> segments_;
  bool directory_unsynced_ = false;
  FreeMap holes_;
  std::vector<Run> retired_now_, retired_before_;
};

}  // namespace atrium
