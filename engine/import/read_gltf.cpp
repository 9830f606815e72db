#include "engine/import/read_gltf.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "engine/import/text.h"

namespace atrium {
namespace {

constexpr std::size_t kGlbHeader = 12, kChunkHeader = 8;

// What a file may require of its reader that changes no surface here or that is read below.
constexpr const char* kKnownExtensions[] = {"KHR_materials_emissive_strength",
                                            "KHR_mesh_quantization",
                                            "KHR_texture_transform",
                                            "KHR_lights_punctual",
                                            "KHR_materials_ior",
                                            "KHR_materials_specular",
                                            "KHR_materials_clearcoat",
                                            "KHR_materials_sheen",
                                            "KHR_materials_transmission",
                                            "KHR_materials_volume",
                                            "KHR_materials_iridescence",
                                            "KHR_materials_unlit",
                                            "KHR_materials_variants",
                                            "KHR_texture_basisu",
                                            "EXT_texture_webp"};

// Column major, as glTF has it.
using Matrix = std::array<double, 16>;
constexpr Matrix kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

Matrix multiply(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t k = 0; k < 4; ++k) c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return c;
}

Vec3 transform(const Matrix& m, const Vec3& x) {
  return {m[0] * x.x + m[4] * x.y + m[8] * x.z + m[12],
          m[1] * x.x + m[5] * x.y + m[9] * x.z + m[13],
          m[2] * x.x + m[6] * x.y + m[10] * x.z + m[14]};
}

bool mirrors(const Matrix& m) {
  const Vec3 x{m[0], m[1], m[2]}, y{m[4], m[5], m[6]}, z{m[8], m[9], m[10]};
  return dot(cross(x, y), z) < 0;
}

Matrix local_matrix(const tinygltf::Node& node) {
  Matrix m = kIdentity;
  if (node.matrix.size() == 16) {
    std::copy(node.matrix.begin(), node.matrix.end(), m.begin());
    return m;
  }
  if (node.rotation.size() == 4) {
    const double x = node.rotation[0], y = node.rotation[1], z = node.rotation[2],
                 w = node.rotation[3];
    m = {1 - 2 * (y * y + z * z),
         2 * (x * y + z * w),
         2 * (x * z - y * w),
         0,
         2 * (x * y - z * w),
         1 - 2 * (x * x + z * z),
         2 * (y * z + x * w),
         0,
         2 * (x * z + y * w),
         2 * (y * z - x * w),
         1 - 2 * (x * x + y * y),
         0,
         0,
         0,
         0,
         1};
  }
  if (node.scale.size() == 3)
    for (std::size_t column = 0; column < 3; ++column)
      for (std::size_t row = 0; row < 3; ++row) m[4 * column + row] *= node.scale[column];
  if (node.translation.size() == 3)
    std::copy(node.translation.begin(), node.translation.end(), m.begin() + 12);
  return m;
}

// A node still to be visited, and where its parent stands.
struct Visit {
  int node = 0;
  Matrix parent = kIdentity;
};

// A number of an accessor's element, whatever it is stored as.
double component(const unsigned char* at, int type, bool normalized) {
  const auto read = [&](auto value, double largest) {
    std::memcpy(&value, at, sizeof value);
    const auto number = static_cast<double>(value);
    return normalized ? std::max(number / largest, -1.0) : number;
  };
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return read(std::int8_t{}, 127);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return read(std::uint8_t{}, 255);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return read(std::int16_t{}, 32767);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return read(std::uint16_t{}, 65535);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return read(std::uint32_t{}, 4294967295.0);
    case TINYGLTF_COMPONENT_TYPE_DOUBLE:
      return read(double{}, 1);
    default:
      return read(float{}, 1);
  }
}

// An accessor's elements, checked to lie within its buffer.
struct Elements {
  const unsigned char* data = nullptr;
  std::size_t count = 0, stride = 0, component_size = 0;
  int type = 0;
  bool normalized = false;
  double at(std::size_t i, std::size_t k) const {
    return component(data + i * stride + k * component_size, type, normalized);
  }
};

bool no_image(tinygltf::Image*, const int, std::string*, std::string*, int, int,
              const unsigned char*, int, void*) {
  return true;
}

class GltfReader {
 public:
  GltfReader(const std::string& path, RawModel& model, WarningLog& warnings)
      : path_(path),
        model_(model),
        warnings_(warnings),
        file_(static_cast<std::uint32_t>(model.files.size())),
        first_face_(model.faces.size()),
        first_material_(static_cast<std::uint32_t>(model.materials.size())) {
    model_.files.push_back(path);
  }

  Status read() {
    const Result<std::string> bytes = read_whole_file(path_);
    if (!bytes.ok()) return bytes.status();
    ATRIUM_RETURN_IF_ERROR(parse(*bytes));
    for (const std::string& name : gltf_.extensionsRequired)
      if (std::find(std::begin(kKnownExtensions), std::end(kKnownExtensions), name) ==
          std::end(kKnownExtensions))
        return broken("extensionsRequired", "'" + name + "' is not supported",
                      "export the scene without it");
    if (gltf_.extensionsUsed.end() !=
        std::find(gltf_.extensionsUsed.begin(), gltf_.extensionsUsed.end(), "KHR_lights_punctual"))
      warnings_.add("point, spot and directional lights ignored: lamps are emissive faces", path_);
    for (const tinygltf::Material& m : gltf_.materials) material(m);
    ATRIUM_RETURN_IF_ERROR(scene());
    if (model_.faces.size() == first_face_)
      return broken("", "holds no triangles", "check that this is the right file");
    return {};
  }

 private:
  Status broken(const std::string& place, const std::string& cause,
                const std::string& remedy) const {
    return Status(Code::kScene, path_, place, cause, remedy);
  }

  Status parse(const std::string& bytes) {
    constexpr const char* kRemedy = "export the file again";
    const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
    const std::string folder = std::filesystem::path(path_).parent_path().string();
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(no_image, nullptr);
    std::string error, warning;
    bool ok = false;
    if (bytes.size() > 0xffffffffu) return broken("", "is larger than 4 GiB", "split the scene");
    const auto size = static_cast<unsigned>(bytes.size());
    if (bytes.starts_with("glTF")) {
      ATRIUM_RETURN_IF_ERROR(check_container(bytes));
      ok = loader.LoadBinaryFromMemory(&gltf_, &error, &warning, data, size, folder);
    } else if (path_.ends_with(".glb") || path_.ends_with(".GLB")) {
      return broken("byte 0", "does not begin with the letters glTF", kRemedy);
    } else {
      ok = loader.LoadASCIIFromString(&gltf_, &error, &warning, bytes.data(), size, folder);
    }
    if (ok) return {};
    std::replace(error.begin(), error.end(), '\n', ' ');
    while (error.ends_with(' ')) error.pop_back();
    return broken("JSON", error.empty() ? "is no glTF 2.0" : error, kRemedy);
  }

  // The header and the chunks of a .glb lie within the file.
  Status check_container(const std::string& bytes) const {
    const auto word = [&](std::size_t at) {
      std::uint32_t value = 0;
      std::memcpy(&value, bytes.data() + at, sizeof value);
      return value;
    };
    const auto cut_off = [&](std::size_t at, const std::string& what) {
      return broken("byte " + std::to_string(at),
                    what + " is cut off: the file has " + std::to_string(bytes.size()) + " bytes",
                    "copy or export the file again");
    };
    if (bytes.size() < kGlbHeader + kChunkHeader) return cut_off(0, "the header");
    if (word(4) != 2)
      return broken("byte 4", "glTF version " + std::to_string(word(4)) + ", not 2",
                    "export it as glTF 2.0");
    const std::size_t length = word(8);
    if (length > bytes.size())
      return cut_off(8, "the container of " + std::to_string(length) + " bytes");
    for (std::size_t at = kGlbHeader; at < length;) {
      if (length - at < kChunkHeader) return cut_off(at, "a chunk's header");
      const std::size_t chunk = word(at);
      if (chunk > length - at - kChunkHeader)
        return cut_off(at, "a chunk of " + std::to_string(chunk) + " bytes");
      at += kChunkHeader + chunk;
    }
    return {};
  }

  void material(const tinygltf::Material& m) {
    RawMaterial raw;
    const std::size_t number = model_.materials.size() - first_material_;
    raw.name = m.name.empty() ? "material " + std::to_string(number) : m.name;
    raw.file = file_;
    raw.library = path_;
    raw.place = "materials[" + std::to_string(number) + "]";
    raw.has_reflectance = true;
    raw.reflectance = Spectrum{1};
    const std::vector<double>& base = m.pbrMetallicRoughness.baseColorFactor;
    for (std::size_t k = 0; k < 3 && k < base.size(); ++k)
      raw.reflectance[static_cast<int>(k)] = base[k];
    if (m.alphaMode != "OPAQUE" && base.size() == 4) raw.opacity = base[3];
    double strength = 1;
    const auto extension = m.extensions.find("KHR_materials_emissive_strength");
    if (extension != m.extensions.end() && extension->second.Has("emissiveStrength"))
      strength = extension->second.Get("emissiveStrength").GetNumberAsDouble();
    for (std::size_t k = 0; k < 3 && k < m.emissiveFactor.size(); ++k)
      raw.emission[static_cast<int>(k)] = m.emissiveFactor[k] * strength;
    raw.textured =
        m.pbrMetallicRoughness.baseColorTexture.index >= 0 || m.emissiveTexture.index >= 0;
    raw.double_sided = m.doubleSided;
    model_.materials.push_back(std::move(raw));
  }

  // All nodes of the scene, parents before children, in the file's order.
  Status scene() {
    std::vector<Visit> pending;
    const auto push = [&](const std::vector<int>& nodes, const Matrix& parent) {
      for (auto n = nodes.rbegin(); n != nodes.rend(); ++n) pending.push_back({*n, parent});
    };
    if (gltf_.scenes.empty()) {
      push(roots(), kIdentity);
    } else {
      const auto number = static_cast<std::size_t>(std::max(gltf_.defaultScene, 0));
      if (number >= gltf_.scenes.size())
        return broken("scene", "there is no scene " + std::to_string(number), "correct the file");
      push(gltf_.scenes[number].nodes, kIdentity);
    }
    std::vector<bool> seen(gltf_.nodes.size(), false);
    while (!pending.empty()) {
      const Visit visit = pending.back();
      pending.pop_back();
      const std::string place = "nodes[" + std::to_string(visit.node) + "]";
      const auto index = static_cast<std::size_t>(visit.node);
      if (visit.node < 0 || index >= gltf_.nodes.size())
        return broken(place, "there is no such node", "correct the file");
      if (seen[index])
        return broken(place, "is reached twice: a child of two nodes, or of itself",
                      "correct the nodes' children");
      seen[index] = true;
      const tinygltf::Node& n = gltf_.nodes[index];
      const Matrix matrix = multiply(visit.parent, local_matrix(n));
      if (n.mesh >= 0) ATRIUM_RETURN_IF_ERROR(mesh(n, place, matrix));
      push(n.children, matrix);
    }
    return {};
  }

  // The nodes that are nobody's children.
  std::vector<int> roots() const {
    std::vector<bool> child(gltf_.nodes.size(), false);
    for (const tinygltf::Node& n : gltf_.nodes)
      for (const int c : n.children)
        if (c >= 0 && static_cast<std::size_t>(c) < child.size())
          child[static_cast<std::size_t>(c)] = true;
    std::vector<int> result;
    for (std::size_t i = 0; i < child.size(); ++i)
      if (!child[i]) result.push_back(static_cast<int>(i));
    return result;
  }

  Status mesh(const tinygltf::Node& n, const std::string& place, const Matrix& matrix) {
    if (static_cast<std::size_t>(n.mesh) >= gltf_.meshes.size())
      return broken(place, "there is no mesh " + std::to_string(n.mesh), "correct the file");
    const tinygltf::Mesh& m = gltf_.meshes[static_cast<std::size_t>(n.mesh)];
    if (n.skin >= 0 || !m.weights.empty())
      warnings_.add("skins and morph targets ignored, the mesh stands as it is", n.name);
    RawObject object;
    object.name = !n.name.empty() ? n.name : !m.name.empty() ? m.name : place;
    object.file = file_;
    object.place_word = "triangle";
    model_.objects.push_back(std::move(object));
    const std::size_t faces = model_.faces.size();
    for (std::size_t p = 0; p < m.primitives.size(); ++p)
      ATRIUM_RETURN_IF_ERROR(
          primitive(m.primitives[p],
                    "meshes[" + std::to_string(n.mesh) + "].primitives[" + std::to_string(p) + "]",
                    matrix, faces));
    if (model_.faces.size() == faces) model_.objects.pop_back();
    return {};
  }

  Status primitive(const tinygltf::Primitive& p, const std::string& place, const Matrix& matrix,
                   std::size_t first_of_object) {
    const int mode = p.mode < 0 ? TINYGLTF_MODE_TRIANGLES : p.mode;
    if (mode < TINYGLTF_MODE_TRIANGLES) {
      warnings_.add("points and lines left out", path_ + ", " + place);
      return {};
    }
    if (mode > TINYGLTF_MODE_TRIANGLE_FAN)
      return broken(place, "has the unknown mode " + std::to_string(mode), "export the file again");
    const auto position = p.attributes.find("POSITION");
    if (position == p.attributes.end()) return {};
    std::uint32_t material = RawFace::kNoMaterial;
    if (p.material >= 0) {
      if (static_cast<std::size_t>(p.material) >= gltf_.materials.size())
        return broken(place, "there is no material " + std::to_string(p.material),
                      "correct the file");
      material = first_material_ + static_cast<std::uint32_t>(p.material);
    }
    const Result<Elements> positions = elements(position->second, TINYGLTF_TYPE_VEC3, place);
    if (!positions.ok()) return positions.status();
    const auto first_vertex = static_cast<std::uint32_t>(model_.vertices.size());
    for (std::size_t i = 0; i < positions->count; ++i) {
      const Vec3 x =
          transform(matrix, {positions->at(i, 0), positions->at(i, 1), positions->at(i, 2)});
      if (!std::isfinite(x.x) || !std::isfinite(x.y) || !std::isfinite(x.z))
        return broken(place + ", accessors[" + std::to_string(position->second) + "], vertex " +
                          std::to_string(i),
                      "its position is not finite", "export the file again");
      model_.vertices.push_back(x);
    }
    std::vector<std::uint32_t> corners;
    ATRIUM_RETURN_IF_ERROR(read_indices(p, place, positions->count, corners));
    add_triangles(corners, mode, mirrors(matrix), first_vertex, material, first_of_object);
    return {};
  }

  Status read_indices(const tinygltf::Primitive& p, const std::string& place, std::size_t vertices,
                      std::vector<std::uint32_t>& corners) const {
    if (p.indices < 0) {
      for (std::size_t i = 0; i < vertices; ++i) corners.push_back(static_cast<std::uint32_t>(i));
      return {};
    }
    const Result<Elements> indices = elements(p.indices, TINYGLTF_TYPE_SCALAR, place);
    if (!indices.ok()) return indices.status();
    for (std::size_t i = 0; i < indices->count; ++i) {
      const double v = indices->at(i, 0);
      if (!(v >= 0 && v < static_cast<double>(vertices)))
        return broken(
            place + ", accessors[" + std::to_string(p.indices) + "], index " + std::to_string(i),
            "points past the " + std::to_string(vertices) + " vertices", "export the file again");
      corners.push_back(static_cast<std::uint32_t>(v));
    }
    return {};
  }

  void add_triangles(const std::vector<std::uint32_t>& corners, int mode, bool mirrored,
                     std::uint32_t first_vertex, std::uint32_t material,
                     std::size_t first_of_object) {
    const bool separate = mode == TINYGLTF_MODE_TRIANGLES;
    for (std::size_t i = 0; i + 2 < corners.size(); i += separate ? 3 : 1) {
      const std::size_t first = mode == TINYGLTF_MODE_TRIANGLE_FAN ? 0 : i;
      // A strip's every other triangle runs the other way.
      const bool swapped = mirrored != (mode == TINYGLTF_MODE_TRIANGLE_STRIP && i % 2 == 1);
      RawFace f;
      f.first_corner = static_cast<std::uint32_t>(model_.corners.size());
      f.corner_count = 3;
      f.object = static_cast<std::uint32_t>(model_.objects.size() - 1);
      f.material = material;
      f.place = static_cast<std::uint32_t>(model_.faces.size() - first_of_object + 1);
      model_.corners.push_back(first_vertex + corners[first]);
      model_.corners.push_back(first_vertex + corners[swapped ? i + 2 : i + 1]);
      model_.corners.push_back(first_vertex + corners[swapped ? i + 1 : i + 2]);
      model_.faces.push_back(f);
    }
  }

  Result<Elements> elements(int index, int type, const std::string& user) const {
    const std::string place = user + ", accessors[" + std::to_string(index) + "]";
    const auto bad = [&](const std::string& cause) {
      return broken(place, cause, "export the file again");
    };
    if (index < 0 || static_cast<std::size_t>(index) >= gltf_.accessors.size())
      return bad("there is no such accessor");
    const tinygltf::Accessor& a = gltf_.accessors[static_cast<std::size_t>(index)];
    if (a.sparse.isSparse) return bad("is sparse, which is not supported");
    if (a.type != type) return bad("has elements of another kind than it is used for");
    if (a.bufferView < 0 || static_cast<std::size_t>(a.bufferView) >= gltf_.bufferViews.size())
      return bad("there is no buffer view " + std::to_string(a.bufferView));
    const tinygltf::BufferView& view = gltf_.bufferViews[static_cast<std::size_t>(a.bufferView)];
    if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= gltf_.buffers.size())
      return bad("there is no buffer " + std::to_string(view.buffer));
    const std::vector<unsigned char>& data =
        gltf_.buffers[static_cast<std::size_t>(view.buffer)].data;
    const int component_size =
        tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(a.componentType));
    const int stride = a.ByteStride(view);
    if (component_size <= 0 || stride <= 0) return bad("has no known component type or stride");
    Elements e;
    e.count = a.count;
    e.stride = static_cast<std::size_t>(stride);
    e.component_size = static_cast<std::size_t>(component_size);
    e.type = a.componentType;
    e.normalized = a.normalized;
    const std::size_t components = static_cast<std::size_t>(
        tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type)));
    const std::size_t size = components * e.component_size;
    if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
      return bad("its buffer view ends past its buffer");
    if (e.count > 0 && (a.byteOffset > view.byteLength || size > view.byteLength - a.byteOffset ||
                        (e.count - 1) > (view.byteLength - a.byteOffset - size) / e.stride))
      return bad("ends past its buffer view");
    e.data = data.data() + view.byteOffset + a.byteOffset;
    return e;
  }

  const std::string& path_;
  RawModel& model_;
  WarningLog& warnings_;
  const std::uint32_t file_;
  const std::size_t first_face_;
  const std::uint32_t first_material_;
  tinygltf::Model gltf_;
};

}  // namespace

Status read_gltf(const std::string& path, RawModel& model, WarningLog& warnings) {
  return GltfReader(path, model, warnings).read();
}

}  // namespace atrium
