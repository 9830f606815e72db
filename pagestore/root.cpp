#include "pagestore/root.h"

#include <algorithm>
#include <cstring>

namespace atrium {

namespace {

constexpr std::array<char, 8> kRootMagic{'A', 'T', 'R', 'I', 'U', 'M', 'R', 'T'};
constexpr std::uint32_t kFormat = 1;

struct RootExtent {
  std::uint64_t first = 0, length = 0, epoch = 0, header_hash = 0, version = 0;
};

struct RootImage {
  std::array<char, 8> magic = kRootMagic;
  std::uint32_t format = kFormat;
  std::uint32_t granule = kGranule;
  StoreUuid uuid{};
  std::uint64_t epoch = 0;
  RootExtent directory, state;
  std::array<std::byte, kGranule - 128> zero{};
  std::uint64_t hash = 0;  // XXH3-64 of all before
};
static_assert(sizeof(RootImage) == kGranule);

std::uint64_t hash_of(const RootImage& image) {
  return hash_bytes(std::as_bytes(std::span(&image, 1)).first(offsetof(RootImage, hash)));
}

RootExtent to_disk(const StoredExtent& e) {
  return {e.first, e.length, e.epoch, e.header_hash, e.version};
}

StoredExtent from_disk(const RootExtent& e) {
  return {.first = e.first,
          .length = e.length,
          .epoch = e.epoch,
          .header_hash = e.header_hash,
          .version = static_cast<std::uint32_t>(e.version)};
}

// A live writer may be half way through a slot just when a reader looks.
constexpr int kReadAttempts = 4;

}  // namespace

std::vector<std::byte> encode_root(const Root& root) {
  RootImage image;
  image.uuid = root.uuid;
  image.epoch = root.epoch;
  image.directory = to_disk(root.directory);
  image.state = to_disk(root.state);
  image.hash = hash_of(image);
  const auto bytes = std::as_bytes(std::span(&image, 1));
  return {bytes.begin(), bytes.end()};
}

RootSlot decode_root(std::span<const std::byte> granule, std::size_t slot) {
  if (std::ranges::all_of(granule, [](std::byte b) { return b == std::byte{0}; })) return {};
  RootImage image;
  std::memcpy(&image, granule.data(), sizeof image);
  if (image.magic != kRootMagic) return {{}, "it does not begin with ATRIUMRT"};
  if (image.hash != hash_of(image)) return {{}, "it does not match its hash (torn or damaged)"};
  if (image.format != kFormat || image.granule != kGranule)
    return {{}, "it is of format " + std::to_string(image.format) + ", not 1"};
  if (slot_of(image.epoch) != slot) return {{}, "it belongs in the other slot"};
  return {Root{image.epoch, image.uuid, from_disk(image.directory), from_disk(image.state)}, ""};
}

Result<RootSlots> read_roots(DiskFile& file) {
  const auto size = file.size();
  if (!size.ok()) return size.status();
  RootSlots slots;
  std::vector<std::byte> granule(kGranule);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (*size < (i + 1) * kGranule) continue;
    for (int attempt = 0; attempt < kReadAttempts; ++attempt) {
      ATRIUM_RETURN_IF_ERROR(file.read(i * kGranule, granule));
      slots[i] = decode_root(granule, i);
      if (slots[i].fault.empty()) break;
    }
  }
  return slots;
}

Status write_root(DiskFile& file, const Root& root) {
  const std::vector<std::byte> image = encode_root(root);
  ATRIUM_RETURN_IF_ERROR(write_all(file, slot_of(root.epoch) * kGranule, image));
  return file.sync();
}

}  // namespace atrium
