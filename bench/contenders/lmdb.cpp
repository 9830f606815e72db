// LMDB: a B+ tree in a mapped file. Reading: no read-ahead but hints for what comes within the next
// few megabytes. Writing: through a writable map, since a transaction's pages would not fit in
// memory otherwise; each commit is synced.
#include <lmdb.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>
#include <filesystem>

#include "bench/contender.h"

namespace atrium {

namespace {

constexpr std::size_t kMapBytes = std::size_t{8} << 30;
constexpr std::size_t kHintBytes = std::size_t{4} << 20;
constexpr std::uintptr_t kPage = 4096;
constexpr mode_t kFileMode = 0644;

Status lmdb_failure(const std::string& dir, const char* call, int error) {
  return Status(Code::kStore, dir, "", std::string(call) + " failed: " + ::mdb_strerror(error));
}

class LmdbContender final : public Contender {
 public:
  explicit LmdbContender(std::string dir) : dir_(std::move(dir)) {}
  ~LmdbContender() override {
    if (transaction_ != nullptr) ::mdb_txn_abort(transaction_);
    if (env_ != nullptr) ::mdb_env_close(env_);
  }
  LmdbContender(const LmdbContender&) = delete;

  Status open(Purpose purpose) {
    reading_ = purpose == Purpose::kRead;
    std::error_code error;
    std::filesystem::create_directories(dir_, error);
    if (const int e = ::mdb_env_create(&env_)) return lmdb_failure(dir_, "mdb_env_create", e);
    if (const int e = ::mdb_env_set_mapsize(env_, kMapBytes))
      return lmdb_failure(dir_, "mdb_env_set_mapsize", e);
    const unsigned flags = reading_ ? MDB_RDONLY | MDB_NORDAHEAD : MDB_WRITEMAP | MDB_NORDAHEAD;
    if (const int e = ::mdb_env_open(env_, dir_.c_str(), flags, kFileMode))
      return lmdb_failure(dir_, "mdb_env_open", e);
    ATRIUM_RETURN_IF_ERROR(begin());
    const unsigned made = reading_ ? 0 : MDB_CREATE;
    if (const int e = ::mdb_dbi_open(transaction_, nullptr, MDB_INTEGERKEY | made, &table_))
      return lmdb_failure(dir_, "mdb_dbi_open", e);
    return {};
  }

  void foresee(std::span<const RecordIndex> reads) override {
    upcoming_.insert(upcoming_.end(), reads.begin(), reads.end());
  }

  Result<std::span<const std::byte>> read(RecordIndex record) override {
    if (next_ < upcoming_.size()) ATRIUM_RETURN_IF_ERROR(hint());
    auto bytes = find(record);
    if (bytes.ok() && !is_whole(*bytes)) return not_whole(dir_, record);
    return bytes;
  }

  Status write(RecordIndex record, std::span<const std::byte> payload) override {
    MDB_val key{sizeof record, &record}, value{payload.size(), nullptr};
    if (const int e = ::mdb_put(transaction_, table_, &key, &value, MDB_RESERVE))
      return lmdb_failure(dir_, "mdb_put", e);
    std::ranges::copy(payload, static_cast<std::byte*>(value.mv_data));
    return {};
  }

  Status commit() override {
    const int e = ::mdb_txn_commit(transaction_);
    transaction_ = nullptr;
    if (e != 0) return lmdb_failure(dir_, "mdb_txn_commit", e);
    return begin();
  }

  std::optional<double> hit_ratio() const override { return std::nullopt; }

 private:
  Status begin() {
    const int e = ::mdb_txn_begin(env_, nullptr, reading_ ? MDB_RDONLY : 0, &transaction_);
    return e == 0 ? Status() : lmdb_failure(dir_, "mdb_txn_begin", e);
  }

  Result<std::span<const std::byte>> find(RecordIndex record) {
    MDB_val key{sizeof record, &record}, value{};
    if (const int e = ::mdb_get(transaction_, table_, &key, &value))
      return lmdb_failure(dir_, "mdb_get", e);
    return std::span(static_cast<const std::byte*>(value.mv_data), value.mv_size);
  }

  // Asks for the next kHintBytes of what was foreseen. A large value's address is known without
  // touching it.
  Status hint() {
    hinted_bytes_ -= std::min(hinted_bytes_, record_sizes()[upcoming_[next_++]]);
    for (; hinted_ < upcoming_.size() && hinted_bytes_ < kHintBytes; ++hinted_) {
      const auto bytes = find(upcoming_[hinted_]);
      if (!bytes.ok()) return bytes.status();
      const auto address = reinterpret_cast<std::uintptr_t>((*bytes).data());
      const std::uintptr_t begin = address / kPage * kPage;
      ::madvise(reinterpret_cast<void*>(begin), address + (*bytes).size() - begin, MADV_WILLNEED);
      hinted_bytes_ += (*bytes).size();
    }
    return {};
  }

  std::string dir_;
  bool reading_ = false;
  MDB_env* env_ = nullptr;
  MDB_txn* transaction_ = nullptr;
  MDB_dbi table_ = 0;
  std::vector<RecordIndex> upcoming_;
  std::size_t next_ = 0, hinted_ = 0, hinted_bytes_ = 0;  // hinted_bytes_: and not read yet
};

Result<std::unique_ptr<Contender>> open_lmdb(const std::string& dir, Purpose purpose) {
  auto contender = std::make_unique<LmdbContender>(dir);
  ATRIUM_RETURN_IF_ERROR(contender->open(purpose));
  return std::unique_ptr<Contender>(std::move(contender));
}

}  // namespace

ContenderKind lmdb_contender() {
  return {"lmdb", "lmdb", true, "LMDB, NORDAHEAD and WILLNEED hints", open_lmdb};
}

}  // namespace atrium
