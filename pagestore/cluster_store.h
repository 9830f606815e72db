// ClusterStore: cluster records between disk and a fixed arena. "The database supports the
// operations of reading, dirtying, and releasing clusters. Releases of dirty data result in
// deferred writes to persistent storage." [THFH94 §4]
//
//   ClusterPin source = store.read(id);       reads, pins; its destruction releases
//   ClusterEdit receiver = store.edit(id);    reads, pins, dirties; may grow the record
//
// Invariants:
//  1. The arena is exact: records in memory, headers and rounding to granules included, never
//     exceed arena_bytes. The memory they lie in is an eighth larger, taken once and never grown:
//     room for holes between records of many sizes, and for what is read ahead. A pinned record is
//     never evicted and never moved; ClusterEdit::resize may move its own, and then its edit is the
//     only pin on it.
//  2. Dirty records reach the disk when they are evicted or at a checkpoint, never otherwise. A
//     record created and not evicted is first written by the checkpoint.
//  3. What the last durable root names is never changed in place: after a crash at any instant
//     the store opens as it was at the last checkpoint.
//  4. Every record is checked (id, store, epoch, hashes) when it is brought in.
//  5. A record has its place on disk from the moment it is dirty, and so have the directory and the
//     state: a full disk shows where a record is created, edited or resized, and never in an
//     eviction or a checkpoint. What was done up to then can always be made durable.
//  6. What is in the arena, and what is counted, does not depend on what was read ahead: a record
//     enters the arena when it is asked for, wherever its bytes already are.
//  7. After a failed sync or root write nothing is written any more: every later write or
//     checkpoint repeats that first error. Reads of what is intact go on.
//
// Thread safety: one thread at a time calls the store, its pins' constructors, destructors and
// resize included. The bytes of pins may be read by any number of threads meanwhile, and those of
// edits written, until the pin is destroyed or resized.
//
// Errors: Code::kStore for the disk and what is on it, Code::kUsage where the arena is too small
// (the remedy names the size that will do). Asking for a record that does not exist, or creating
// one that does, is a mistake of the caller and checked.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "engine/status.h"
#include "pagestore/aligned_bytes.h"
#include "pagestore/directory.h"
#include "pagestore/disk.h"
#include "pagestore/foresight.h"
#include "pagestore/record.h"

namespace atrium {

class Arena;
class ClusterStore;
class PageFile;
class TraceWriter;
struct Root;

struct StoreOptions {
  std::size_t arena_bytes = std::size_t{32} << 20;  // rounded down to granules
  std::string policy = "lru";                       // as parse_policy takes it
  Io io = Io::kMmap;
  // Of a trace from elsewhere: records are charged their payload alone, and lie in this much memory.
  // 0: as invariant 1 says.
  std::size_t payload_arena_memory = 0;
  Disk* disk = nullptr;  // nullptr: the machine's own
};

// kReadOnly takes no lock and may look at a live run; the others take it. Where the newest root does
// not verify, kRecover goes on from the older one (recovery_note says so), and the others fail.
enum class OpenMode { kReadOnly, kReadWrite, kRecover };

// Counts since the store was opened. Bytes are payload bytes.
struct StoreCounters {
  std::uint64_t requests = 0;  // read() and edit() that succeeded
  std::uint64_t reads = 0;     // records brought into the arena
  std::uint64_t reads_ahead = 0;  // of reads: begun before they were asked for
  std::uint64_t writes = 0;    // records brought back to disk, by eviction or checkpoint
  std::uint64_t bytes_read = 0;
  std::uint64_t bytes_written = 0;
  std::uint64_t checkpoint_writes = 0;  // of writes: those by checkpoints (the final flush)
  std::uint64_t checkpoint_bytes = 0;
  std::uint64_t evictions = 0;
  std::uint64_t fragmentation_evictions = 0;  // of evictions: room enough, but in pieces
  std::uint64_t compactions = 0;              // records slid together instead
  std::uint64_t streamed_reads = 0, streamed_bytes_read = 0;  // past the arena
  std::uint64_t streamed_writes = 0, streamed_bytes_written = 0;
  std::uint64_t checkpoints = 0;
  std::uint64_t overhead_bytes = 0;  // written besides payloads: headers, padding, directory, roots
  double io_seconds = 0;             // inside calls to the disk
  double stall_seconds = 0;          // of them: waiting for bytes to be read

  std::uint64_t hits() const { return requests - reads; }
  double hit_ratio() const {  // 1 - reads / requests; 1 where nothing was requested
    return requests == 0 ? 1.0 : 1.0 - static_cast<double>(reads) / static_cast<double>(requests);
  }
  StoreCounters operator-(const StoreCounters& before) const;  // what happened since `before`
  StoreCounters operator+(const StoreCounters& more) const { return *this - (StoreCounters{} - more); }
};

// A record held in the arena for reading; several on one record are allowed.
class [[nodiscard]] ClusterPin {
 public:
  ClusterPin() = default;
  ClusterPin(ClusterPin&& other) noexcept { swap(other); }
  ClusterPin& operator=(ClusterPin&& other) noexcept {
    ClusterPin(std::move(other)).swap(*this);
    return *this;
  }
  ~ClusterPin();

  RecordId id() const { return id_; }
  std::span<const std::byte> bytes() const { return bytes_; }  // 64-byte aligned

 private:
  friend class ClusterStore;
  friend class ClusterEdit;
  ClusterPin(ClusterStore& store, StoredRecord& record);
  void swap(ClusterPin& other) noexcept;

  ClusterStore* store_ = nullptr;
  StoredRecord* record_ = nullptr;
  RecordId id_;
  std::span<const std::byte> bytes_;
};

// A record held in the arena to be changed: dirty from here on, released at destruction.
class [[nodiscard]] ClusterEdit {
 public:
  ClusterEdit() = default;
  ClusterEdit(ClusterEdit&& other) noexcept { swap(other); }
  ClusterEdit& operator=(ClusterEdit&& other) noexcept {
    ClusterEdit(std::move(other)).swap(*this);
    return *this;
  }
  ~ClusterEdit();

  RecordId id() const { return id_; }
  std::span<std::byte> bytes() const { return bytes_; }  // 64-byte aligned

  // The pin's record to be changed after all: no further request.
  static Result<ClusterEdit> of(ClusterPin pin);

  // Makes the record `size` bytes long: what it held is kept, what is new is zero. May move it and
  // evict others; spans from bytes() before are void. This must be the only pin on the record.
  // On error the record is as it was.
  Status resize(std::size_t size);

 private:
  friend class ClusterStore;
  ClusterEdit(ClusterStore& store, StoredRecord& record);
  void swap(ClusterEdit& other) noexcept;

  ClusterStore* store_ = nullptr;
  StoredRecord* record_ = nullptr;
  RecordId id_;
  std::span<std::byte> bytes_;
};

class ClusterStore {
 public:
  // Makes an empty store in `dir` (made if missing), durable on return, with `state`. Refuses (kUsage) a
  // directory that holds one already; one whose making was cut short is made anew.
  static Result<std::unique_ptr<ClusterStore>> create(const std::string& dir,
                                                      const StoreOptions& options,
                                                      std::span<const std::byte> state = {});
  // False where none is, and where the making of one was cut short.
  static bool is_there(Disk& disk, const std::string& dir);
  static Result<std::unique_ptr<ClusterStore>> open(const std::string& dir,
                                                    const StoreOptions& options, OpenMode mode);
  // Discards what was not checkpointed. No pin may be left.
  ~ClusterStore();
  ClusterStore(const ClusterStore&) = delete;
  ClusterStore& operator=(const ClusterStore&) = delete;

  Result<ClusterPin> read(RecordId id);
  // As read(), for requests of other caches' traces: what is larger than the arena, or what the
  // policy had rather not have, is counted as read but read past the arena; no pin then.
  Result<std::optional<ClusterPin>> read_or_pass(RecordId id);
  Result<ClusterEdit> edit(RecordId id);                                  // not kReadOnly
  Status create_record(RecordId id, std::span<const std::byte> payload);  // not kReadOnly
  bool in_arena(RecordId id) const { return records_.at(id).resident(); }
  bool contains(RecordId id) const {
    const auto found = records_.find(id);
    return found != records_.end() && found->second.exists();
  }
  std::size_t size(RecordId id) const;       // payload bytes
  std::vector<RecordId> record_ids() const;  // sorted

  // These will be the next requests, in this order, after those foreseen already. The store reads
  // ahead by it, and a policy with foresight evicts by it.
  void foresee(std::span<const RecordId> ids);
  void forget_foreseen();  // the next requests are others
  std::uint64_t foreseen() const { return foresight_.end() - foresight_.now(); }  // still to come

  // From now on all that is asked of the store is told to this writer, too; nothing may be pinned.
  void record_to(TraceWriter* trace) { trace_ = trace; }

  // Past the arena, for what is made once and read once a pass: no request, never cached, counted
  // apart. The record must not be in the arena. What stream_in returns holds until the next call of
  // any of these.
  Result<std::span<const std::byte>> stream_in(RecordId id);
  Status stream_out(RecordId id, std::span<const std::byte> payload);  // made or replaced
  void drop_streamed(RecordId id);  // out of the next checkpoint on

  // Makes everything durable, `state` (the caller's own, opaque) with it. No edit may be out.
  Status checkpoint(std::span<const std::byte> state);
  std::span<const std::byte> state() const { return state_; }  // of the last durable root
  std::uint64_t epoch() const { return epoch_; }  // checkpoints since creation, that one counted

  // kRecover: where opening had to pass over a root that does not verify: which, why, and what was done. Ok
  // otherwise.
  const Status& recovery_note() const { return recovery_note_; }

  // Reads everything the roots name from disk and checks it: roots, directories, states, every
  // header, payload and padding. The error names the record and its place.
  Status verify_all();

  const StoreCounters& counters() const { return counters_; }  // copy and subtract for a span

  std::uint64_t live_bytes() const;                 // payload bytes of all records
  std::uint64_t live_bytes(RecordKind kind) const;  // of one kind
  std::uint64_t file_bytes() const;                 // of the page files on disk
  std::uint64_t allocated_bytes() const;            // of them: extents, of both roots, and claims

  // What a record of `payload_bytes` takes in the arena: header, and whole granules.
  static std::size_t arena_cost(std::size_t payload_bytes);
  std::size_t arena_bytes() const { return capacity_; }
  std::size_t arena_used_bytes() const { return resident_bytes_; }
  std::size_t arena_peak_bytes() const { return resident_peak_bytes_; }
  std::size_t pinned_bytes() const { return pinned_bytes_; }  // of the arena
  std::size_t pinned_peak_bytes() const { return pinned_peak_bytes_; }
  // Memory for an arena of `capacity` bytes: that, its holes, and what is read ahead.
  static std::size_t arena_memory(std::size_t capacity);
  static std::size_t read_ahead_bytes(std::size_t capacity);
  // Memory beside it: the directory, the image of it that a checkpoint makes, foresight, and the
  // record that was streamed last.
  std::size_t directory_bytes() const;

 private:
  friend class ClusterPin;
  friend class ClusterEdit;

  struct RootContents;  // what one root names, as read from disk

  ClusterStore(const std::string& dir, const StoreOptions& options, OpenMode mode);
  Status make_directory();
  Status prepare(const StoreOptions& options);  // lock, files, arena, policy; no records yet

  // Records in the arena: cluster_store.cpp
  StoredRecord& add_record(StoredRecord record);
  StoredRecord& put_record(const StoredRecord& record);
  StoredRecord& record_of(RecordId id);
  bool hits(const StoredRecord& record);
  void release(StoredRecord& record);
  void count_request(StoredRecord& record);
  Status bring_in(StoredRecord& record);
  Status pass(StoredRecord& record);
  Status fits(RecordId id, std::size_t bytes, std::size_t own_bytes) const;
  Status make_room(RecordId id, std::size_t bytes);
  Result<std::uint64_t> find_slot(RecordId id, std::uint64_t granules);
  Status evict_one();
  Status evict_for_a_hole(RecordId id, std::uint64_t granules);
  bool compact(const StoredRecord* movable);
  void leave_slot(StoredRecord& record);
  Status resize(StoredRecord& record, std::size_t size);
  std::size_t charge_of(std::uint64_t length) const;
  void charge(std::size_t bytes);
  void count_pinned(std::size_t bytes);
  std::span<std::byte> image_of(const StoredRecord& record) const;
  std::span<std::byte> payload_of(const StoredRecord& record) const;

  // What is known of the requests to come: look_ahead.cpp
  void look_ahead(const StoredRecord& requested);
  void come_into_sight();
  bool in_sight(std::uint64_t number) const;
  void tell_next(const StoredRecord& record);
  void read_ahead();
  bool read_one_ahead(StoredRecord& record);
  Status end_read_ahead(StoredRecord& record);
  bool give_up_reads();

  // Records and their extents: extents.cpp
  Status claim(StoredRecord& record, std::uint64_t granules);
  Status claim_own_records();
  Status claim_run(Run& run, std::uint64_t granules);
  Status write_back(StoredRecord& record);
  Result<StoredExtent> write_image(std::span<std::byte> image, RecordId id, std::uint64_t length,
                                   std::uint32_t version, Run& claim);
  Status read_image(std::span<std::byte> image, RecordId id, const StoredExtent& extent,
                    const StoreUuid& uuid, Known known = Known::kNow);
  Status read_requested(std::span<std::byte> image, const StoredRecord& record);
  Status check_image(std::span<const std::byte> image, RecordId id, const StoredExtent& extent,
                     const StoreUuid& uuid);
  void leave_extent(const StoredExtent& extent);

  // Roots and what they name: checkpoint.cpp
  Status flush_dirty();
  Result<Root> write_contents(std::span<const std::byte> state);
  Result<StoredExtent> write_own_record(RecordId id, std::span<const std::byte> payload,
                                        const StoredExtent& last, Run& claim);
  void become(const Root& root, std::span<const std::byte> state);
  Status load_newest_root();
  Status load(const Root& root);
  void protect_older(const Root& older);
  Result<RootContents> read_contents(const Root& root);
  Result<std::vector<std::byte>> read_own_record(RecordId id, const StoredExtent& extent,
                                                 const StoreUuid& uuid);
  Status verify(const Root& root);
  Status unless_moved_on(Status fault, std::uint64_t steps);

  std::string dir_;
  OpenMode mode_;
  bool writes() const { return mode_ != OpenMode::kReadOnly; }
  Disk& disk_;
  std::unique_ptr<DiskLock> lock_;
  std::unique_ptr<DiskFile> roots_;
  std::unique_ptr<PageFile> pages_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<ReadQueue> queue_;  // reads into the arena; waits for them before it goes
  std::unique_ptr<Policy> policy_;
  PolicyChoice choice_;
  Foresight foresight_;
  TraceWriter* trace_ = nullptr;
  std::uint64_t scanned_ = 0;        // requests before this one are in the arena, coming, or tried
  std::size_t coming_bytes_ = 0;     // of the arena's memory: being read ahead of their requests
  StoreUuid uuid_{};
  std::uint64_t epoch_ = 0;  // of the last durable root; what is written now belongs to epoch_ + 1
  std::unordered_map<RecordId, StoredRecord> records_;
  std::vector<StoredRecord*> by_number_;
  StoredExtent directory_on_disk_, state_on_disk_;
  std::vector<std::byte> state_;
  Status recovery_note_;
  Status failed_;  // the first failure that nothing may be written after
  StoreCounters counters_;
  std::array<std::uint64_t, kRecordKinds> live_bytes_{};
  bool charges_payload_ = false;
  std::size_t capacity_ = 0, resident_bytes_ = 0, resident_peak_bytes_ = 0;  // as charged
  std::size_t pinned_bytes_ = 0, pinned_peak_bytes_ = 0;
  Run directory_claim_, state_claim_;
  AlignedBytes streamed_;  // the image that was streamed last
  std::size_t edits_ = 0;
};

}  // namespace atrium
