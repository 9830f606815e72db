#include <bit>
#include <numbers>

#include "apps/export/formats.h"
#include "apps/output.h"
#include "apps/picture/tone.h"

namespace atrium {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY is written as memory holds it");

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string header(const SurfaceMesh& mesh) {
  return "ply\nformat binary_little_endian 1.0\ncomment atrium; metres; radiosity in lm/m2\n"
         "element vertex " +
         std::to_string(mesh.vertices.size()) +
         "\nproperty double x\nproperty double y\nproperty double z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\n"
         "property float radiosity_r\nproperty float radiosity_g\nproperty float radiosity_b\n"
         "element face " +
         std::to_string(mesh.triangles.size()) +
         "\nproperty list uchar uint vertex_indices\nend_header\n";
}

void append_vertex(std::string& bytes, const MeshVertex& v, const SurfaceMesh& mesh) {
  const Vec3 x = v.x + mesh.origin;
  for (int k = 0; k < 3; ++k) append(bytes, x[k]);
  Image pixel(1, 1);
  for (int k = 0; k < 3; ++k)
    pixel.pixels[0][std::size_t(k)] = static_cast<float>(v.radiosity[k] / std::numbers::pi);
  pixel.pixels[0] = tone_mapped(pixel.pixels[0], mesh.exposure);
  for (const std::uint8_t c : srgb_bytes(pixel)) append(bytes, c);
  for (int k = 0; k < 3; ++k) append(bytes, static_cast<float>(v.radiosity[k]));
}

}  // namespace

Result<Exported> write_ply(const SurfaceMesh& mesh, const std::string& path) {
  constexpr std::uint8_t kCorners = 3;
  std::string bytes = header(mesh);
  for (const MeshVertex& v : mesh.vertices) append_vertex(bytes, v, mesh);
  for (const MeshObject& o : mesh.objects)
    for (std::uint32_t t = 0; t < o.triangle_count; ++t) {
      append(bytes, kCorners);
      for (const std::uint32_t c : mesh.triangles[o.first_triangle + t])
        append(bytes, o.first_vertex + c);
    }
  ATRIUM_RETURN_IF_ERROR(write_output(path, {bytes}));
  return Exported{bytes.size(), mesh.vertices.size(), mesh.triangles.size()};
}

}  // namespace atrium
