// OBJ and MTL of a generated model. Numbers are the shortest decimals that read back as the same
// doubles (17 digits at most); a group's vertices are shared among its faces.
#include <array>
#include <bit>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <tuple>

#include "data/generate.h"

namespace atrium {
namespace {

constexpr std::size_t kFlushAt = std::size_t{1} << 20;  // bytes of text gathered before a write

// Text on its way to a file.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& path)
      : path_(path), file_(path, std::ios::binary | std::ios::trunc) {}

  TextFile& operator<<(std::string_view text) {
    text_ += text;
    if (text_.size() >= kFlushAt) flush();
    return *this;
  }
  TextFile& operator<<(double value) {
    std::array<char, 32> digits;
    const double plain = value == 0 ? 0 : value;  // no "-0"
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), plain).ptr;
    return *this << std::string_view(digits.data(), end);
  }
  TextFile& operator<<(std::uint64_t value) {
    return *this << std::string_view(std::to_string(value));
  }
  TextFile& operator<<(const Vec3& v) { return *this << v.x << " " << v.y << " " << v.z; }

  Status close() {
    flush();
    file_.close();
    if (file_) return {};
    return {Code::kStore, path_.string(), "", "cannot be written",
            "see that the folder exists, is writable and has room"};
  }

 private:
  void flush() {
    file_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
    text_.clear();
  }

  std::filesystem::path path_;
  std::ofstream file_;
  std::string text_;
};

Status write_materials(const GeneratedModel& model, const std::filesystem::path& path) {
  TextFile out(path);
  out << "# " << model.title << ": Kd reflectance, Ke luminance in cd/m2\n";
  for (const Paint& p : model.paints) {
    out << "\nnewmtl " << p.name << "\nKd " << p.reflectance << "\n";
    if (p.emits()) out << "Ke " << p.luminance << "\n";
  }
  return out.close();
}

using Bits = std::tuple<std::uint64_t, std::uint64_t, std::uint64_t>;
Bits bits(const Vec3& v) {
  const auto of = [](double x) { return std::bit_cast<std::uint64_t>(x == 0 ? 0.0 : x); };
  return {of(v.x), of(v.y), of(v.z)};
}

}  // namespace

Status write_obj(const GeneratedModel& model, const std::string& path) {
  std::filesystem::path materials(path);
  materials.replace_extension(".mtl");
  if (materials == std::filesystem::path(path))
    return {Code::kUsage, path, "", "is where the materials go", "end the model's name in .obj"};
  ATRIUM_RETURN_IF_ERROR(write_materials(model, materials));

  const ModelCounts n = model.counts();
  TextFile out(path);
  out << "# " << model.title << ": metres, z up; " << n.clusters << " clusters, " << n.patches
      << " polygons, " << n.lights << " lights\nmtllib " << materials.filename().string() << "\n";
  std::uint64_t written = 0;  // vertices
  for (const GeneratedGroup& group : model.groups) {
    out << "\no " << group.name << "\n";
    const auto faces = std::span(model.faces).subspan(group.first_face, group.face_count);
    std::map<Bits, std::uint64_t> index;
    for (const GeneratedFace& f : faces) {
      for (const Vec3& v : model.polygon(f)) {
        if (!index.emplace(bits(v), written + 1).second) continue;
        out << "v " << v << "\n";
        ++written;
      }
    }
    const GeneratedFace* before = nullptr;
    for (const GeneratedFace& f : faces) {
      if (!before || before->paint != f.paint)
        out << "usemtl " << model.paints[f.paint].name << "\n";
      before = &f;
      out << "f";
      for (const Vec3& v : model.polygon(f)) out << " " << index.at(bits(v));
      out << "\n";
    }
  }
  return out.close();
}

}  // namespace atrium
