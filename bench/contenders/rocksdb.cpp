// RocksDB with values in blob files, read past the page cache into its own cache; writes go to its
// log first, and a commit syncs that.
#include <rocksdb/cache.h>
#include <rocksdb/db.h>
#include <rocksdb/statistics.h>
#include <rocksdb/table.h>

#include <filesystem>

#include "bench/contender.h"

namespace atrium {

namespace {

constexpr std::size_t kBlockCacheBytes = std::size_t{4} << 20;  // indexes; values are in blobs
constexpr std::size_t kWriteBufferBytes = std::size_t{8} << 20;
constexpr std::size_t kSmallestBlob = 4096;

rocksdb::Slice key_of(const RecordIndex& record) {
  return {reinterpret_cast<const char*>(&record), sizeof record};
}

class RocksContender final : public Contender {
 public:
  explicit RocksContender(std::string dir) : dir_(std::move(dir)) {}

  Status open(Purpose purpose) {
    std::error_code error;
    std::filesystem::create_directories(dir_, error);
    rocksdb::BlockBasedTableOptions table;
    table.block_cache = rocksdb::NewLRUCache(kBlockCacheBytes);
    rocksdb::Options options;
    options.create_if_missing = purpose != Purpose::kRead;
    options.table_factory.reset(rocksdb::NewBlockBasedTableFactory(table));
    options.compression = rocksdb::kNoCompression;
    options.enable_blob_files = true;
    options.min_blob_size = kSmallestBlob;
    options.enable_blob_garbage_collection = true;
    options.write_buffer_size = kWriteBufferBytes;
    options.use_direct_reads = true;
    options.use_direct_io_for_flush_and_compaction = true;
    options.statistics = statistics_;
    if (purpose == Purpose::kRead) options.blob_cache = rocksdb::NewLRUCache(kArenaBytes);
    rocksdb::DB* db = nullptr;
    ATRIUM_RETURN_IF_ERROR(checked("DB::Open", rocksdb::DB::Open(options, dir_, &db)));
    db_.reset(db);
    return {};
  }

  Result<std::span<const std::byte>> read(RecordIndex record) override {
    value_.Reset();
    ATRIUM_RETURN_IF_ERROR(
        checked("Get", db_->Get({}, db_->DefaultColumnFamily(), key_of(record), &value_)));
    const auto bytes = std::as_bytes(std::span(value_.data(), value_.size()));
    if (!is_whole(bytes)) return not_whole(dir_, record);
    return bytes;
  }

  Status write(RecordIndex record, std::span<const std::byte> payload) override {
    value_.Reset();
    const rocksdb::Slice value(reinterpret_cast<const char*>(payload.data()), payload.size());
    return checked("Put", db_->Put({}, key_of(record), value));
  }

  Status commit() override { return checked("SyncWAL", db_->SyncWAL()); }

  std::optional<double> hit_ratio() const override {
    const auto hits = statistics_->getTickerCount(rocksdb::BLOB_DB_CACHE_HIT);
    const auto misses = statistics_->getTickerCount(rocksdb::BLOB_DB_CACHE_MISS);
    if (hits + misses == 0) return std::nullopt;
    return static_cast<double>(hits) / static_cast<double>(hits + misses);
  }

 private:
  Status checked(const char* call, const rocksdb::Status& status) const {
    if (status.ok()) return {};
    return Status(Code::kStore, dir_, "", std::string(call) + " failed: " + status.ToString());
  }

  std::string dir_;
  std::shared_ptr<rocksdb::Statistics> statistics_ = rocksdb::CreateDBStatistics();
  std::unique_ptr<rocksdb::DB> db_;
  rocksdb::PinnableSlice value_;  // gone before its database
};

Result<std::unique_ptr<Contender>> open_rocksdb(const std::string& dir, Purpose purpose) {
  auto contender = std::make_unique<RocksContender>(dir);
  ATRIUM_RETURN_IF_ERROR(contender->open(purpose));
  return std::unique_ptr<Contender>(std::move(contender));
}

}  // namespace

ContenderKind rocksdb_contender() {
  return {"rocksdb", "rocksdb", true, "RocksDB, BlobDB, direct reads", open_rocksdb};
}

}  // namespace atrium
