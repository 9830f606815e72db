#include "scheduler/run_model.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <type_traits>

namespace atrium {

namespace {

constexpr std::uint32_t kRunModelVersion = 1;

// One description of the record serves both directions: Out writes what In reads.
class Out {
 public:
  template <class T>
  void value(T& x) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(&x, sizeof x);
  }
  template <class T>
  void array(std::vector<T>& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::uint64_t n = v.size();
    value(n);
    put(v.data(), n * sizeof(T));
  }
  void text(std::string& s) {
    std::uint64_t n = s.size();
    value(n);
    put(s.data(), n);
  }
  bool resize(std::vector<std::string>&, std::uint64_t) { return true; }
  std::vector<std::byte> bytes;

 private:
  void put(const void* data, std::size_t size) {
    const auto* b = static_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), b, b + size);
  }
};

class In {
 public:
  explicit In(std::span<const std::byte> b) : bytes_(b) {}
  template <class T>
  void value(T& x) {
    take(&x, sizeof x);
  }
  template <class T>
  void array(std::vector<T>& v) {
    std::uint64_t n = 0;
    value(n);
    if (n > bytes_.size() / sizeof(T)) return fail();
    v.resize(n);
    take(v.data(), n * sizeof(T));
  }
  void text(std::string& s) {
    std::uint64_t n = 0;
    value(n);
    if (n > bytes_.size()) return fail();
    s.resize(n);
    take(s.data(), n);
  }
  bool resize(std::vector<std::string>& v, std::uint64_t n) {
    if (n > bytes_.size()) {
      fail();
      return false;
    }
    v.resize(n);
    return true;
  }
  bool ok() const { return ok_ && bytes_.empty(); }

 private:
  void fail() { ok_ = false; }
  void take(void* to, std::size_t size) {
    if (size > bytes_.size()) return fail();
    if (size > 0) std::memcpy(to, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }
  std::span<const std::byte> bytes_;
  bool ok_ = true;
};

template <class Archive>
void texts(Archive& a, std::vector<std::string>& v) {
  std::uint64_t n = v.size();
  a.value(n);
  if (!a.resize(v, n)) return;
  for (std::string& s : v) a.text(s);
}

template <class Archive, class T>
void rows(Archive& a, Rows<T>& r) {
  a.array(r.starts);
  a.array(r.items);
}

template <class Archive>
void exchange(Archive& a, RunModel& run) {
  a.value(run.frame);
  a.value(run.bounds);
  a.value(run.tolerance);
  a.value(run.order);
  texts(a, run.files);
  texts(a, run.object_names);
  texts(a, run.material_names);
  Model& m = run.model;
  a.array(m.vertices);
  a.array(m.patches);
  a.array(m.clusters);
  a.array(m.cells);
  a.array(m.portals);
  a.array(m.portal_vertices);
  rows(a, m.cells_of_cluster);
  rows(a, m.visible);
  a.value(m.rooms);
  a.value(m.dark_surfaces);
  a.value(m.tolerance);
}

Result<RunModel> from_bytes(std::span<const std::byte> bytes, const std::string& directory) {
  In in(bytes);
  std::uint32_t version = 0;
  in.value(version);
  RunModel run;
  if (version == kRunModelVersion) exchange(in, run);
  if (version != kRunModelVersion || !in.ok())
    return Status(Code::kStore, directory, "model record", "not one of this version of atrium",
                  "solve the scene again");
  return run;
}

}  // namespace

std::vector<std::byte> to_bytes(RunModel run) {
  Out out;
  std::uint32_t version = kRunModelVersion;
  out.value(version);
  exchange(out, run);
  return std::move(out.bytes);
}

Status store_run_model(std::span<const std::byte> all, ClusterStore& store) {
  for (std::size_t at = 0, i = 0; at < all.size(); at += kRunModelPiece, ++i)
    ATRIUM_RETURN_IF_ERROR(
        store.create_record(record_id(RecordKind::kModel, i),
                            all.subspan(at, std::min(kRunModelPiece, all.size() - at))));
  return {};
}

Result<RunModel> load_run_model(ClusterStore& store, const std::string& directory) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; store.contains(record_id(RecordKind::kModel, i)); ++i) {
    Result<ClusterPin> pin = store.read(record_id(RecordKind::kModel, i));
    if (!pin.ok()) return pin.status();
    bytes.insert(bytes.end(), pin->bytes().begin(), pin->bytes().end());
  }
  if (bytes.empty())
    return Status(Code::kUsage, directory, "", "holds no solution yet",
                  "let atrium solve run until its first checkpoint");
  return from_bytes(bytes, directory);
}

}  // namespace atrium
