// SimulatedDisk: a disk in memory that keeps apart what is written from what is durable, counts its
// calls, and can fill up, fail, write short and lose power.
//
// A write is pending until the file's next sync; a file's length and the blocks behind it are
// durable with the sync too, and a file that was made, renamed or removed is so after
// sync_directory. On power loss any subset of what is pending reaches the disk, each write whole,
// torn at a sector, or not at all; a file may keep its new length without the blocks, vanish, or be
// there again. A sync that fails has dropped what was pending: it is read until the power goes, and
// no later sync brings it down. A queued read happens at once or when it is waited for, by turns.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "pagestore/disk.h"

namespace atrium {

class SimulatedDisk final : public Disk {
 public:
  static constexpr std::uint64_t kSector = 512;

  struct File {
    std::vector<std::byte> now, durable;
    std::uint64_t reserved = 0, durably_reserved = 0;  // bytes backed by blocks
    std::vector<std::pair<std::uint64_t, std::vector<std::byte>>> pending;
    bool shortened = false;  // since the last sync
    bool name_durable = false;
    bool locked = false;
    std::shared_ptr<File> replaced;  // what had its name before, until that is durable
  };

  // What becomes of call number `n` (from 0) of those that open, read, write, reserve, sync, rename
  // or remove.
  enum class Fault { kNone, kError, kShort, kPowerOff };
  std::function<Fault(std::uint64_t n, const std::string& call)> fault;

  std::uint64_t capacity = ~std::uint64_t{0};  // bytes of all files
  std::uint64_t calls = 0;
  bool powered = true;
  std::map<std::string, File> files;
  std::map<std::string, File> removed;  // not durably

  // The disk after power came back.
  void lose_power_and_restart(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    for (auto& [path, file] : removed)
      if (random() % 2 == 0) files.try_emplace(path, std::move(file));
    removed.clear();
    for (auto it = files.begin(); it != files.end();) {
      File& file = it->second;
      file.locked = false;
      if (!file.name_durable && random() % 2 == 0) {
        if (!file.replaced) {
          it = files.erase(it);
          continue;
        }
        const auto before = file.replaced;
        file = *before;
      }
      file.replaced.reset();
      if (file.now.size() != file.durable.size() && random() % 2 == 0)
        file.durable.resize(file.now.size());
      for (const auto& [offset, bytes] : file.pending) land(file.durable, offset, bytes, random);
      file.now = file.durable;
      file.reserved = file.durably_reserved;
      file.pending.clear();
      file.shortened = false;
      file.name_durable = true;
      ++it;
    }
    powered = true;
    fault = nullptr;
  }

  std::uint64_t used() const {
    std::uint64_t bytes = 0;
    for (const auto& [path, file] : files) bytes += file.reserved;
    return bytes;
  }

  bool exists(const std::string& path) const override { return files.contains(path); }
  Status make_directory(const std::string&) override { return {}; }

  Result<std::unique_ptr<DiskFile>> open(const std::string& path, DiskAccess access) override {
    if (next("open") != Fault::kNone || (access == DiskAccess::kRead && !files.contains(path)))
      return failure(path, "open");
    const auto [file, made] = files.try_emplace(path);
    if (const auto before = removed.find(path); made && before != removed.end()) {
      file->second.replaced = std::make_shared<File>(std::move(before->second));
      removed.erase(before);
    }
    return std::unique_ptr<DiskFile>(std::make_unique<Handle>(*this, path));
  }

  std::unique_ptr<ReadQueue> read_queue(unsigned) override { return std::make_unique<Queue>(); }

  Result<std::uint64_t> free_bytes(const std::string&) const override {
    return capacity - std::min(capacity, used());
  }

  Status remove(const std::string& path) override {
    if (next("remove") != Fault::kNone) return failure(path, "remove");
    const auto file = files.extract(path);
    if (!file.empty() && file.mapped().name_durable) removed[path] = std::move(file.mapped());
    return {};
  }

  Status rename(const std::string& from, const std::string& to) override {
    if (next("rename") != Fault::kNone) return failure(from, "rename");
    auto before = files.contains(to) ? std::make_shared<File>(files[to]) : nullptr;
    File file = std::move(files[from]);
    files.erase(from);
    file.name_durable = false;
    file.replaced = std::move(before);
    files[to] = std::move(file);
    return {};
  }

  Status sync_directory(const std::string& path) override {
    if (next("sync_directory") != Fault::kNone) return failure(path, "sync_directory");
    for (auto& [name, file] : files)
      if (name.starts_with(path + "/")) {
        file.name_durable = true;
        file.replaced.reset();
      }
    std::erase_if(removed, [&](const auto& file) { return file.first.starts_with(path + "/"); });
    return {};
  }

  Result<std::unique_ptr<DiskLock>> lock(const std::string& path) override {
    File& file = files[path];
    if (file.locked) return Status(Code::kStore, path, "", "in use by process 1", "");
    file.locked = true;
    return std::unique_ptr<DiskLock>(std::make_unique<Lock>(*this, path));
  }

 private:
  class Lock final : public DiskLock {
   public:
    Lock(SimulatedDisk& disk, std::string path) : disk_(disk), path_(std::move(path)) {}
    ~Lock() override {
      if (disk_.files.contains(path_)) disk_.files[path_].locked = false;
    }

   private:
    SimulatedDisk& disk_;
    std::string path_;
  };

  class Queue final : public ReadQueue {
   public:
    const std::string& name() const override { return name_; }
    void submit(DiskFile& file, std::uint64_t offset, std::span<std::byte> into,
                std::uint64_t ticket) override {
      const bool at_once = ++submitted_ % 2 == 0;
      reads_[ticket] = {&file, offset, into, at_once, at_once ? file.read(offset, into) : Status()};
    }
    Status wait(std::uint64_t ticket) override {
      const Read read = reads_.extract(ticket).mapped();
      return read.done ? read.result : read.file->read(read.offset, read.into);
    }

   private:
    struct Read {
      DiskFile* file;
      std::uint64_t offset;
      std::span<std::byte> into;
      bool done;
      Status result;
    };
    std::map<std::uint64_t, Read> reads_;
    std::uint64_t submitted_ = 0;
    std::string name_ = "simulated";
  };

  class Handle final : public DiskFile {
   public:
    Handle(SimulatedDisk& disk, std::string path) : disk_(disk), path_(std::move(path)) {}
    const std::string& path() const override { return path_; }
    Result<std::uint64_t> size() const override {
      return std::uint64_t{disk_.files[path_].now.size()};
    }
    Status allocate(std::uint64_t size) override {
      if (disk_.next("allocate") != Fault::kNone) return failure(path_, "allocate");
      return disk_.reserve(path_, size);
    }
    Status truncate(std::uint64_t size) override {
      if (disk_.next("truncate") != Fault::kNone) return failure(path_, "truncate");
      File& file = disk_.files[path_];
      file.shortened |= size < file.now.size();
      file.now.resize(size);
      file.reserved = std::min(file.reserved, size);
      return {};
    }
    Result<std::size_t> write_some(std::uint64_t offset,
                                   std::span<const std::byte> bytes) override {
      const Fault what = disk_.next("write");
      File& file = disk_.files[path_];
      if (what == Fault::kShort) bytes = bytes.first((bytes.size() + 1) / 2);
      if (what == Fault::kPowerOff)  // under way when the power went: may land, may tear
        file.pending.emplace_back(offset, std::vector(bytes.begin(), bytes.end()));
      if (what == Fault::kError || what == Fault::kPowerOff) return failure(path_, "write");
      if (offset + bytes.size() > file.reserved) {
        if (path_.find("/pages.") != std::string::npos)
          return failure(path_, "a write past what is reserved");
        ATRIUM_RETURN_IF_ERROR(disk_.reserve(path_, offset + bytes.size()));
      }
      std::memcpy(file.now.data() + offset, bytes.data(), bytes.size());
      file.pending.emplace_back(offset, std::vector(bytes.begin(), bytes.end()));
      return bytes.size();
    }
    Status read(std::uint64_t offset, std::span<std::byte> bytes) override {
      const File& file = disk_.files[path_];
      if (disk_.next("read") != Fault::kNone) return failure(path_, "read");
      if (offset + bytes.size() > file.now.size()) return failure(path_, "the file ends early");
      std::memcpy(bytes.data(), file.now.data() + offset, bytes.size());
      return {};
    }
    void will_read(std::uint64_t, std::uint64_t) override {}
    Status sync() override {
      const Fault what = disk_.next("sync");
      File& file = disk_.files[path_];
      if (what == Fault::kNone) bring_down(file);
      if (what != Fault::kPowerOff) file.pending.clear();
      return what == Fault::kNone ? Status() : failure(path_, "sync");
    }

   private:
    SimulatedDisk& disk_;
    std::string path_;
  };

  static Status failure(const std::string& path, const std::string& what) {
    return Status(Code::kStore, path, "", what + " failed", "");
  }

  Status reserve(const std::string& path, std::uint64_t size) {
    File& file = files[path];
    if (size <= file.reserved) return {};
    if (used() + size - file.reserved > capacity)
      return Status(Code::kStore, path, "", "no space left", "make room");
    file.now.resize(std::max<std::uint64_t>(size, file.now.size()));
    file.reserved = size;
    return {};
  }

  static void bring_down(File& file) {
    file.durable.resize(file.now.size());
    if (file.shortened)
      file.durable = file.now;
    else
      for (const auto& [offset, bytes] : file.pending)
        std::ranges::copy(bytes, file.durable.begin() + static_cast<std::ptrdiff_t>(offset));
    file.shortened = false;
    file.durably_reserved = file.reserved;
  }

  Fault next(const std::string& call) {
    const std::uint64_t n = calls++;
    if (!powered) return Fault::kError;
    const Fault what = fault ? fault(n, call) : Fault::kNone;
    if (what == Fault::kPowerOff) powered = false;
    return what;
  }

  static void land(std::vector<std::byte>& disk, std::uint64_t offset,
                   const std::vector<std::byte>& bytes, std::mt19937_64& random) {
    const auto fate = random() % 3;  // none, whole, torn
    for (std::uint64_t at = 0; at < bytes.size(); at += kSector) {
      const bool lands = fate == 1 || (fate == 2 && random() % 2 == 0);
      const std::uint64_t n = std::min<std::uint64_t>(kSector, bytes.size() - at);
      if (lands && offset + at + n <= disk.size())
        std::memcpy(disk.data() + offset + at, bytes.data() + at, n);
    }
  }
};

}  // namespace atrium
