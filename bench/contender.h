// Contender: one way of keeping records on disk and having them back with little memory. Each reads
// and checks the same bytes: by XXH3, whatever it brings in from disk or from the operating
// system's page cache. What lies in a cache of its own is not checked again.
//
// What a contender says is wrong is a Status; the benchmark ends with it.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/workload.h"
#include "engine/status.h"

namespace atrium {

class Contender {
 public:
  virtual ~Contender() = default;
  // These reads come next, in this order: for those that can do something with it.
  virtual void foresee(std::span<const RecordIndex> /*reads*/) {}
  // The record's payload, good until the next call.
  virtual Result<std::span<const std::byte>> read(RecordIndex record) = 0;
  virtual Status write(RecordIndex record, std::span<const std::byte> payload) = 0;  // or rewrites
  virtual Status commit() = 0;  // what was written is durable on return
  // Share of reads that its own cache answered; none where it has no cache of its own.
  virtual std::optional<double> hit_ratio() const = 0;
};

enum class Purpose { kMake, kRead, kRewrite };  // kMake, kRewrite: in a new directory

struct ContenderKind {
  std::string name;
  std::string data;  // those of one name read the same files
  bool rewrites;     // can replace records by larger ones
  std::string title;
  Result<std::unique_ptr<Contender>> (*open)(const std::string& dir, Purpose purpose);
};

// Those that were built. Libraries that are missing leave theirs out.
std::vector<ContenderKind> contenders();

// bench/contenders/, a file each
std::vector<ContenderKind> atrium_contenders();
ContenderKind pread_contender();
ContenderKind lmdb_contender();
ContenderKind rocksdb_contender();

Status not_whole(const std::string& dir, RecordIndex record);

}  // namespace atrium
