#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>

#include <cstring>
#include <exception>

#include "apps/picture/encode.h"

namespace atrium {
namespace {

// A file in memory, for OpenEXR to write to.
class MemoryFile : public Imf::OStream {
 public:
  MemoryFile() : Imf::OStream("memory") {}
  void write(const char bytes[], int count) override {
    const auto n = static_cast<std::size_t>(count);
    if (bytes_.size() < at_ + n) bytes_.resize(at_ + n);
    std::memcpy(bytes_.data() + at_, bytes, n);
    at_ += n;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t at) override { at_ = at; }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

constexpr const char* kChannelNames[] = {"R", "G", "B"};

}  // namespace

Result<std::string> encode_exr(const Image& image) try {
  MemoryFile file;
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer frame;
  for (int c = 0; c < 3; ++c) {
    header.channels().insert(kChannelNames[c], Imf::Channel(Imf::FLOAT));
    auto* base = reinterpret_cast<char*>(const_cast<float*>(&image.pixels[0][std::size_t(c)]));
    frame.insert(kChannelNames[c], Imf::Slice(Imf::FLOAT, base, sizeof(Pixel),
                                              sizeof(Pixel) * std::size_t(image.width)));
  }
  {
    Imf::OutputFile out(file, header);
    out.setFrameBuffer(frame);
    out.writePixels(image.height);
  }
  return file.take();
} catch (const std::exception& e) {
  return Status(Code::kInternal, "EXR", "", e.what());
}

}  // namespace atrium
