#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include <nlohmann/json.hpp>

#include "apps/export/formats.h"
#include "apps/output.h"
#include "apps/picture/tone.h"

namespace atrium {
namespace {

static_assert(std::endian::native == std::endian::little, "GLB is written as memory holds it");

using Json = nlohmann::ordered_json;

// [glTF 2.0 §4.4, §5.1, §5.11]
constexpr std::uint32_t kMagic = 0x46546c67, kVersion = 2;
constexpr std::uint32_t kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;
constexpr std::uint64_t kMostBytes = 0xffffffff;
constexpr int kFloat = 5126, kUnsignedInt = 5125;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr double kNodeStep = 1024;  // m

enum View { kPositions, kColours, kRadiosities, kIndices, kViews };

using Float3 = std::array<float, 3>;

Float3 floats(const Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

template <class T>
std::string_view bytes_of(const std::vector<T>& v) {
  return {reinterpret_cast<const char*>(v.data()), v.size() * sizeof(T)};
}

void append_word(std::string& text, std::uint32_t word) {
  text.append(reinterpret_cast<const char*>(&word), sizeof word);
}

class GlbWriter {
 public:
  explicit GlbWriter(const SurfaceMesh& mesh) : mesh_(mesh) {
    for (int k = 0; k < 3; ++k) node_[k] = kNodeStep * std::round(mesh.origin[k] / kNodeStep);
    for (const MeshVertex& v : mesh.vertices) {
      const Pixel luminance{static_cast<float>(v.radiosity.x / std::numbers::pi),
                            static_cast<float>(v.radiosity.y / std::numbers::pi),
                            static_cast<float>(v.radiosity.z / std::numbers::pi)};
      positions_.push_back(floats(v.x + (mesh.origin - node_)));
      colours_.push_back(tone_mapped(luminance, mesh.exposure));
      radiosities_.push_back(floats(v.radiosity));
    }
  }

  Result<Exported> write(const std::string& path) {
    std::string json = document().dump(-1, ' ', false, Json::error_handler_t::replace);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::uint64_t binary = binary_bytes();
    constexpr std::uint64_t kHeads = 12 + 8 + 8;
    const std::uint64_t total = kHeads + json.size() + binary;
    if (total > kMostBytes)
      return Status(Code::kUsage, path, "", "a GLB holds 4 GiB at most",
                    "export to .ply, or solve with a larger --min-edge");
    std::string head;
    for (const std::uint32_t w : {kMagic, kVersion, static_cast<std::uint32_t>(total),
                                  static_cast<std::uint32_t>(json.size()), kJsonChunk})
      append_word(head, w);
    head += json;
    append_word(head, static_cast<std::uint32_t>(binary));
    append_word(head, kBinaryChunk);
    ATRIUM_RETURN_IF_ERROR(write_output(path, {head, bytes_of(positions_), bytes_of(colours_),
                                               bytes_of(radiosities_), bytes_of(mesh_.triangles)}));
    return Exported{total, mesh_.vertices.size(), mesh_.triangles.size()};
  }

 private:
  std::uint64_t binary_bytes() const {
    return 3 * bytes_of(positions_).size() + bytes_of(mesh_.triangles).size();
  }

  Json view(std::uint64_t offset, std::uint64_t length, int target) const {
    Json v{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}};
    if (target == kArrayBuffer) v["byteStride"] = sizeof(Float3);
    v["target"] = target;
    return v;
  }

  Json views() const {
    const std::uint64_t n = bytes_of(positions_).size();
    return Json::array({view(0, n, kArrayBuffer), view(n, n, kArrayBuffer),
                        view(2 * n, n, kArrayBuffer),
                        view(3 * n, bytes_of(mesh_.triangles).size(), kElementArrayBuffer)});
  }

  Json corner_accessor(View from, const MeshObject& o) const {
    return {{"bufferView", int(from)},
            {"byteOffset", std::uint64_t(o.first_vertex) * sizeof(Float3)},
            {"componentType", kFloat},
            {"count", o.vertex_count},
            {"type", "VEC3"}};
  }

  Json position_accessor(const MeshObject& o) const {
    Float3 lo, hi;
    lo.fill(std::numeric_limits<float>::infinity());
    hi.fill(-std::numeric_limits<float>::infinity());
    for (std::uint32_t i = 0; i < o.vertex_count; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        lo[k] = std::min(lo[k], positions_[o.first_vertex + i][k]);
        hi[k] = std::max(hi[k], positions_[o.first_vertex + i][k]);
      }
    Json a = corner_accessor(kPositions, o);
    a["min"] = lo;
    a["max"] = hi;
    return a;
  }

  Json index_accessor(const MeshObject& o) const {
    return {{"bufferView", int(kIndices)},
            {"byteOffset", std::uint64_t(o.first_triangle) * sizeof(mesh_.triangles[0])},
            {"componentType", kUnsignedInt},
            {"count", 3 * std::uint64_t(o.triangle_count)},
            {"type", "SCALAR"}};
  }

  Json document() const {
    Json accessors = Json::array(), meshes = Json::array(), nodes = Json::array(),
         children = Json::array();
    for (const MeshObject& o : mesh_.objects) {
      const std::size_t first = accessors.size();
      accessors.push_back(position_accessor(o));
      accessors.push_back(corner_accessor(kColours, o));
      accessors.push_back(corner_accessor(kRadiosities, o));
      accessors.push_back(index_accessor(o));
      const Json attributes{{"POSITION", first}, {"COLOR_0", first + 1}, {"_RADIOSITY", first + 2}};
      const Json primitive{{"attributes", attributes}, {"indices", first + 3}, {"material", 0}};
      nodes.push_back({{"name", o.name}, {"mesh", meshes.size()}});
      meshes.push_back({{"name", o.name}, {"primitives", Json::array({primitive})}});
      children.push_back(children.size());
    }
    Json root{{"name", "scene"}};
    if (!children.empty()) root["children"] = children;
    root["translation"] = {node_.x, node_.y, node_.z};
    nodes.push_back(root);
    Json json{{"asset", {{"version", "2.0"}, {"generator", "atrium"}}},
              {"extensionsUsed", {"KHR_materials_unlit"}},
              {"extras", {{"exposure", mesh_.exposure}, {"_RADIOSITY", "lm/m2"}}},
              {"scene", 0},
              {"scenes", Json::array({Json{{"nodes", {nodes.size() - 1}}}})},
              {"nodes", nodes}};
    if (children.empty()) return json;
    json["meshes"] = meshes;
    json["materials"] = Json::array(
        {Json{{"name", "radiosity"}, {"extensions", {{"KHR_materials_unlit", Json::object()}}}}});
    json["accessors"] = accessors;
    json["bufferViews"] = views();
    json["buffers"] = Json::array({Json{{"byteLength", binary_bytes()}}});
    return json;
  }

  const SurfaceMesh& mesh_;
  Vec3 node_{0};  // m, in the files' frame
  std::vector<Float3> positions_, colours_, radiosities_;
};

}  // namespace

Result<Exported> write_glb(const SurfaceMesh& mesh, const std::string& path) {
  return GlbWriter(mesh).write(path);
}

}  // namespace atrium
