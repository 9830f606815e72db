// Checkpoint and recovery: from one root to the next, and back to the newest that verifies.
//
// A checkpoint is, in this order: dirty records to extents of their own; directory and state
// likewise; sync the page files; the root into its slot; sync it. A crash before the last of these
// leaves the root before, and everything it names, as they were. There is no log.
#include <algorithm>
#include <filesystem>
#include <random>

#include "engine/check.h"
#include "pagestore/arena.h"
#include "pagestore/cluster_store.h"
#include "pagestore/disk.h"
#include "pagestore/io_clock.h"
#include "pagestore/page_file.h"
#include "pagestore/policy.h"
#include "pagestore/root.h"
#include "pagestore/trace_writer.h"

namespace atrium {

namespace {

constexpr RecordId kDirectoryId = record_id(RecordKind::kDirectory, 0);
constexpr RecordId kStateId = record_id(RecordKind::kDirectory, 1);

std::string roots_path(const std::string& dir) { return dir + "/roots"; }

StoreUuid new_uuid() {
  std::random_device entropy;
  StoreUuid uuid;
  for (std::byte& b : uuid) b = static_cast<std::byte>(entropy());
  return uuid;
}

// The roots that are whole, newest first.
std::vector<Root> whole_roots(const RootSlots& slots) {
  std::vector<Root> roots;
  for (const RootSlot& slot : slots)
    if (slot.root) roots.push_back(*slot.root);
  std::ranges::sort(roots, std::greater{}, &Root::epoch);
  return roots;
}

std::string slot_place(std::size_t slot) { return "root slot " + std::to_string(slot); }

Status slot_fault(const RootSlots& slots, const std::string& path) {
  for (std::size_t i = 0; i < slots.size(); ++i)
    if (!slots[i].fault.empty())
      return Status(Code::kStore, path, slot_place(i), slots[i].fault, kDamageRemedy);
  return {};
}

// Epoch 1 is the empty store and goes into slot 1: while slot 0 is empty and slot 1 not whole, no
// store was ever finished here.
bool store_was_made(const RootSlots& slots) {
  return !slots[slot_of(0)].empty() || slots[slot_of(1)].root.has_value();
}

// Reads under way at a time; a disk is busy from 8 to 16 on.
constexpr unsigned kReadDepth = 16;

// A reader of a live run may be overtaken while it opens the store.
constexpr int kOpenAttempts = 4;

}  // namespace

struct ClusterStore::RootContents {
  std::vector<DirectoryEntry> entries;
  std::vector<std::byte> state;
};

Result<std::unique_ptr<ClusterStore>> ClusterStore::create(const std::string& dir,
                                                           const StoreOptions& options,
                                                           std::span<const std::byte> state) {
  std::unique_ptr<ClusterStore> store(new ClusterStore(dir, options, OpenMode::kReadWrite));
  ATRIUM_RETURN_IF_ERROR(store->make_directory());
  ATRIUM_RETURN_IF_ERROR(store->prepare(options));
  const auto slots = read_roots(*store->roots_);
  if (!slots.ok()) return slots.status();
  if (store_was_made(*slots))
    return Status(Code::kUsage, dir, "", "it holds a page store already",
                  "resume that run, or give another directory");
  ATRIUM_RETURN_IF_ERROR(store->roots_->allocate(kRootFileBytes));
  ATRIUM_RETURN_IF_ERROR(store->disk_.sync_directory(dir));
  store->uuid_ = new_uuid();
  ATRIUM_RETURN_IF_ERROR(store->checkpoint(state));
  store->counters_ = {};
  return store;
}

Result<std::unique_ptr<ClusterStore>> ClusterStore::open(const std::string& dir,
                                                         const StoreOptions& options,
                                                         OpenMode mode) {
  for (int attempt = 1;; ++attempt) {
    std::unique_ptr<ClusterStore> store(new ClusterStore(dir, options, mode));
    if (!store->disk_.exists(roots_path(dir)))
      return Status(Code::kStore, dir, "", "there is no page store here",
                    "give the directory of a run");
    ATRIUM_RETURN_IF_ERROR(store->prepare(options));
    const Status loaded = store->load_newest_root();
    if (loaded.ok()) {
      store->counters_ = {};
      return store;
    }
    const bool overtaken = !store->unless_moved_on(Status(), 1).ok();
    if (!overtaken || attempt == kOpenAttempts) return loaded;
  }
}

bool ClusterStore::is_there(Disk& disk, const std::string& dir) {
  if (!disk.exists(roots_path(dir))) return false;
  const auto file = disk.open(roots_path(dir), DiskAccess::kRead);
  if (!file.ok()) return true;  // opening it will say why
  const auto slots = read_roots(**file);
  return !slots.ok() || store_was_made(*slots);
}

// The name of a directory made here is durable, as what is in it will be.
Status ClusterStore::make_directory() {
  if (disk_.exists(dir_)) return {};
  ATRIUM_RETURN_IF_ERROR(disk_.make_directory(dir_));
  const std::string parent = std::filesystem::path(dir_).parent_path();
  return disk_.sync_directory(parent.empty() ? "." : parent);
}

Status ClusterStore::prepare(const StoreOptions& options) {
  const DiskAccess access = writes() ? DiskAccess::kReadWrite : DiskAccess::kRead;
  if (writes()) {
    auto lock = disk_.lock(dir_ + "/lock");
    if (!lock.ok()) return lock.status();
    lock_ = std::move(lock).value();
  }
  auto roots = disk_.open(roots_path(dir_), access);
  if (!roots.ok()) return roots.status();
  roots_ = std::move(roots).value();
  auto pages = PageFile::open(disk_, dir_, access);
  if (!pages.ok()) return pages.status();
  pages_ = std::move(pages).value();
  charges_payload_ = options.payload_arena_memory > 0;
  capacity_ = charges_payload_ ? options.arena_bytes : options.arena_bytes / kGranule * kGranule;
  if (capacity_ < kGranule)
    return Status(Code::kUsage, "arena", "", "it is smaller than one granule",
                  "give it at least " + std::to_string(kGranule) + " bytes");
  auto arena = Arena::make(charges_payload_
                               ? options.payload_arena_memory + read_ahead_bytes(capacity_)
                               : arena_memory(capacity_));
  if (!arena.ok()) return arena.status();
  arena_ = std::move(arena).value();
  queue_ = disk_.read_queue(kReadDepth);
  const auto policy = parse_policy(options.policy);
  if (!policy.ok()) return policy.status();
  choice_ = *policy;
  policy_ = make_policy(choice_, capacity_);
  return {};
}

Status ClusterStore::checkpoint(std::span<const std::byte> state) {
  ATRIUM_CHECK(writes() && edits_ == 0);
  ATRIUM_RETURN_IF_ERROR(flush_dirty());
  const auto root = write_contents(state);
  if (!root.ok()) return root.status();
  const IoClock clock(counters_.io_seconds);
  Status durable = pages_->sync();
  if (durable.ok()) durable = write_root(*roots_, *root);
  if (!durable.ok()) {
    // From here on the disk may hold the new root or the old one, and pages that no sync will
    // bring down any more: nothing may be written over either.
    failed_ = Status(durable.code(), durable.file(), durable.place(), durable.cause(),
                     "stop here: resume goes on from the last root that is whole");
    return failed_;
  }
  become(*root, state);
  if (trace_ != nullptr) trace_->checkpoint();
  return {};
}

Status ClusterStore::flush_dirty() {
  std::vector<StoredRecord*> dirty;
  for (StoredRecord* record : by_number_)
    if (record->dirty) dirty.push_back(record);
  std::ranges::sort(dirty, {}, &StoredRecord::id);  // neighbours by id are neighbours on disk
  for (StoredRecord* record : dirty) {
    ATRIUM_RETURN_IF_ERROR(write_back(*record));
    ++counters_.checkpoint_writes;
    counters_.checkpoint_bytes += record->length;
  }
  return {};
}

// The directory and the state, not yet durable, and the root that names them.
Result<Root> ClusterStore::write_contents(std::span<const std::byte> state) {
  std::vector<DirectoryEntry> entries;
  entries.reserve(records_.size());
  for (const StoredRecord* record : by_number_)
    if (record->exists()) entries.push_back(entry_of(record->id, record->on_disk));
  std::ranges::sort(entries, {}, &DirectoryEntry::id);
  const auto directory = write_own_record(kDirectoryId, std::as_bytes(std::span(entries)),
                                          directory_on_disk_, directory_claim_);
  if (!directory.ok()) return directory.status();
  const auto state_extent = write_own_record(kStateId, state, state_on_disk_, state_claim_);
  if (!state_extent.ok()) {
    directory_claim_ = {directory->first, directory->granules()};
    return state_extent.status();
  }
  return Root{.epoch = epoch_ + 1, .uuid = uuid_, .directory = *directory, .state = *state_extent};
}

Result<StoredExtent> ClusterStore::write_own_record(RecordId id, std::span<const std::byte> payload,
                                                    const StoredExtent& last, Run& claim) {
  const auto image = streamed_.granules(granules_of(payload.size()));
  std::ranges::copy(payload, image.begin() + sizeof(RecordHeader));
  const std::uint32_t version = last.exists() ? last.version + 1 : 0;
  ATRIUM_RETURN_IF_ERROR(claim_run(claim, image.size() / kGranule));
  auto extent = write_image(image, id, payload.size(), version, claim);
  if (extent.ok()) counters_.overhead_bytes += payload.size();
  return extent;
}

// The root is durable: what only the older one named is free.
void ClusterStore::become(const Root& root, std::span<const std::byte> state) {
  for (const StoredExtent& last : {directory_on_disk_, state_on_disk_})
    if (last.exists()) leave_extent(last);
  pages_->root_is_durable();
  directory_on_disk_ = root.directory;
  state_on_disk_ = root.state;
  epoch_ = root.epoch;
  state_ = std::vector(state.begin(), state.end());
  ++counters_.checkpoints;
  counters_.overhead_bytes += kGranule;
}

Status ClusterStore::load_newest_root() {
  const auto slots = read_roots(*roots_);
  if (!slots.ok()) return slots.status();
  const auto roots = whole_roots(*slots);
  Status fault = slot_fault(*slots, roots_->path());
  if (!roots.empty()) epoch_ = roots.front().epoch;
  if (!fault.ok() && (mode_ != OpenMode::kRecover || roots.empty())) return fault;
  for (std::size_t i = 0; i < roots.size(); ++i) {
    const Status loaded = load(roots[i]);
    if (loaded.ok()) {
      if (i + 1 < roots.size()) protect_older(roots[i + 1]);
      if (fault.ok()) return {};
      recovery_note_ = Status(fault.code(), fault.file(), fault.place(), fault.cause(),
                              "went on from the root of epoch " + std::to_string(epoch_));
      return checkpoint(state_);  // over the faulty slot: two whole roots again
    }
    if (mode_ != OpenMode::kRecover) return loaded;
    if (fault.ok()) fault = loaded;
  }
  if (!fault.ok()) return fault;
  return Status(Code::kStore, roots_->path(), "", "no root was ever written",
                "the store's making was cut short: solve again");
}

Status ClusterStore::load(const Root& root) {
  pages_->forget_what_is_taken();
  records_.clear();
  by_number_.clear();
  live_bytes_ = {};
  auto contents = read_contents(root);
  if (!contents.ok()) return contents.status();
  const auto take = [&](RecordId id, const StoredExtent& extent) {
    if (pages_->take(extent.first, extent.granules())) return Status();
    return Status(Code::kStore, pages_->path_of(extent.first),
                  to_string(id) + " at " + PageFile::place_of(extent.first),
                  "another record lies there too, or the page file ends before its end",
                  kDamageRemedy);
  };
  ATRIUM_RETURN_IF_ERROR(take(kDirectoryId, root.directory));
  ATRIUM_RETURN_IF_ERROR(take(kStateId, root.state));
  for (const DirectoryEntry& entry : contents->entries) {
    const RecordId id{entry.id};
    const StoredExtent extent = extent_of(entry);
    ATRIUM_RETURN_IF_ERROR(take(id, extent));
    StoredRecord record;
    record.id = id;
    record.on_disk = extent;
    record.version = extent.version + 1;
    record.length = extent.length;
    add_record(record);
  }
  uuid_ = root.uuid;
  epoch_ = root.epoch;
  directory_on_disk_ = root.directory;
  state_on_disk_ = root.state;
  state_ = std::move(contents->state);
  return {};
}

// What only the older root names must stay until it is overwritten. Where it cannot be read it
// protects nothing, and verify_all says so.
void ClusterStore::protect_older(const Root& older) {
  const auto protect = [&](const StoredExtent& extent) {
    if (pages_->take(extent.first, extent.granules()))
      pages_->retired_before(extent.first, extent.granules());
  };
  const auto contents = read_contents(older);
  if (!contents.ok()) return;
  protect(older.directory);
  protect(older.state);
  for (const DirectoryEntry& entry : (*contents).entries) protect(extent_of(entry));
}

Result<ClusterStore::RootContents> ClusterStore::read_contents(const Root& root) {
  auto directory = read_own_record(kDirectoryId, root.directory, root.uuid);
  if (!directory.ok()) return directory.status();
  auto state = read_own_record(kStateId, root.state, root.uuid);
  if (!state.ok()) return state.status();
  auto entries = decode_directory(*directory, pages_->path_of(root.directory.first));
  if (!entries.ok()) return entries.status();
  return RootContents{std::move(entries).value(), std::move(state).value()};
}

Result<std::vector<std::byte>> ClusterStore::read_own_record(RecordId id,
                                                             const StoredExtent& extent,
                                                             const StoreUuid& uuid) {
  const auto image = streamed_.granules(extent.granules());
  ATRIUM_RETURN_IF_ERROR(read_image(image, id, extent, uuid));
  const auto payload = image.subspan(sizeof(RecordHeader), extent.length);
  return std::vector(payload.begin(), payload.end());
}

Status ClusterStore::verify_all() {
  const auto slots = read_roots(*roots_);
  if (!slots.ok()) return slots.status();
  ATRIUM_RETURN_IF_ERROR(slot_fault(*slots, roots_->path()));
  for (const Root& root : whole_roots(*slots)) ATRIUM_RETURN_IF_ERROR(verify(root));
  return {};
}

Status ClusterStore::verify(const Root& root) {
  const auto contents = read_contents(root);
  if (!contents.ok()) return contents.status();
  for (const DirectoryEntry& entry : (*contents).entries) {
    const StoredExtent extent = extent_of(entry);
    ATRIUM_RETURN_IF_ERROR(read_image(streamed_.granules(extent.granules()), RecordId{entry.id},
                                      extent, root.uuid));
  }
  return {};
}

// `fault`, unless a live run has checkpointed `steps` times or more since this reader opened the
// store: then what it looked at may have been reused, and nothing is wrong.
Status ClusterStore::unless_moved_on(Status fault, std::uint64_t steps) {
  if (writes()) return fault;
  const auto slots = read_roots(*roots_);
  if (!slots.ok()) return fault;
  const auto roots = whole_roots(*slots);
  if (roots.empty() || roots.front().epoch < epoch_ + steps) return fault;
  return Status(Code::kStore, dir_, "", "a live run has overtaken this reader",
                "open the store again");
}

}  // namespace atrium
