// Records of plain arrays, one after the other: written, and read back as long as there is enough.
// Little endian, as in memory.
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace atrium {

class RecordOut {
 public:
  explicit RecordOut(std::size_t bytes = 0) { bytes_.reserve(bytes); }
  template <class T>
  void put(std::span<const T> items) {
    const auto bytes = std::as_bytes(items);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

class RecordIn {
 public:
  explicit RecordIn(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class T>
  bool get(std::vector<T>& items, std::size_t count) {
    if (count > bytes_.size() / sizeof(T)) return false;
    items.resize(count);
    if (count > 0) std::memcpy(items.data(), bytes_.data(), count * sizeof(T));
    bytes_ = bytes_.subspan(count * sizeof(T));
    return true;
  }
  bool empty() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace atrium
