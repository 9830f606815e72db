#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <array>
#include <cmath>
#include <cstring>
#include <sstream>

#include "test/apps/program.h"

namespace atrium::testing {
namespace {

using Float3 = std::array<float, 3>;

constexpr double kTolerance = 0.02 * kFurnaceRadiosity;  // what solve was asked for, the default
constexpr double kCubeArea = 6 * kFurnaceSide * kFurnaceSide;  // m²

class Glb {
 public:
  explicit Glb(const std::string& path) {
    tinygltf::TinyGLTF reader;
    std::string error, warning;
    ok = reader.LoadBinaryFromFile(&model, &error, &warning, path);
    EXPECT_TRUE(ok) << error;
    EXPECT_EQ(warning, "");
  }

  template <class T>
  std::vector<T> read(int accessor, int component, int type) const {
    const tinygltf::Accessor& a = model.accessors[std::size_t(accessor)];
    const tinygltf::BufferView& view = model.bufferViews[std::size_t(a.bufferView)];
    const tinygltf::Buffer& buffer = model.buffers[std::size_t(view.buffer)];
    EXPECT_EQ(a.componentType, component);
    EXPECT_EQ(a.type, type);
    EXPECT_EQ(a.byteOffset % 4, 0u);
    EXPECT_EQ(view.byteOffset % 4, 0u);
    EXPECT_LE(a.byteOffset + a.count * sizeof(T), view.byteLength);
    EXPECT_LE(view.byteOffset + view.byteLength, buffer.data.size());
    std::vector<T> values(a.count);
    std::memcpy(values.data(), buffer.data.data() + view.byteOffset + a.byteOffset,
                a.count * sizeof(T));
    return values;
  }
  std::vector<Float3> vectors(int accessor) const {
    return read<Float3>(accessor, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3);
  }

  bool ok = false;
  tinygltf::Model model;
};

double triangle_area(const Float3& a, const Float3& b, const Float3& c) {
  double u[3], v[3];
  for (std::size_t k = 0; k < 3; ++k) u[k] = b[k] - a[k], v[k] = c[k] - a[k];
  return 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                          u[0] * v[1] - u[1] * v[0]);
}

TEST(Export, GlbHoldsTheWholeSurfaceAndItsExactLight) {
  const Folder folder;
  const Ended e = run({"export", furnace_run(), "-o", folder / "cube.glb"});
  ASSERT_EQ(e.code, 0) << e.err;
  const Glb glb(folder / "cube.glb");
  ASSERT_TRUE(glb.ok);
  double area = 0;
  for (const tinygltf::Mesh& mesh : glb.model.meshes)
    for (const tinygltf::Primitive& p : mesh.primitives) {
      const std::vector<Float3> x = glb.vectors(p.attributes.at("POSITION"));
      const std::vector<Float3> colours = glb.vectors(p.attributes.at("COLOR_0"));
      const std::vector<Float3> light = glb.vectors(p.attributes.at("_RADIOSITY"));
      const auto indices = glb.read<std::uint32_t>(p.indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                                                   TINYGLTF_TYPE_SCALAR);
      ASSERT_EQ(colours.size(), x.size());
      ASSERT_EQ(light.size(), x.size());
      const tinygltf::Accessor& bounds =
          glb.model.accessors[std::size_t(p.attributes.at("POSITION"))];
      for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
          EXPECT_GE(x[i][k], bounds.minValues[k]);
          EXPECT_LE(x[i][k], bounds.maxValues[k]);
          EXPECT_GE(colours[i][k], 0);
          EXPECT_LE(colours[i][k], 1);
          EXPECT_NEAR(light[i][k], kFurnaceRadiosity, kTolerance);
        }
      ASSERT_EQ(indices.size() % 3, 0u);
      for (std::size_t i = 0; i < indices.size(); i += 3) {
        for (std::size_t k = 0; k < 3; ++k) ASSERT_LT(indices[i + k], x.size());
        area += triangle_area(x[indices[i]], x[indices[i + 1]], x[indices[i + 2]]);
      }
    }
  EXPECT_NEAR(area, kCubeArea, 1e-6 * kCubeArea);
}

TEST(Export, EqualSolutionsGiveEqualBytes) {
  const Folder folder;
  for (const char* kind : {".glb", ".ply", ".csv"}) {
    const std::string one = folder / ("one" + std::string(kind));
    const std::string two = folder / ("two" + std::string(kind));
    ASSERT_EQ(run({"export", furnace_run(), "-o", one}).code, 0);
    ASSERT_EQ(run({"export", furnace_run(), "-o", two}).code, 0);
    EXPECT_EQ(read_file(one), read_file(two)) << kind;
    EXPECT_FALSE(read_file(one).empty()) << kind;
  }
}

TEST(Export, PlyIsAsLongAsItsHeaderSays) {
  const Folder folder;
  ASSERT_EQ(run({"export", furnace_run(), "-o", folder / "cube.ply"}).code, 0);
  const std::string ply = read_file(folder / "cube.ply");
  const auto count = [&](const std::string& element) {
    return std::stoul(ply.substr(ply.find(element) + element.size()));
  };
  const std::string end = "end_header\n";
  constexpr std::size_t kVertex = 3 * sizeof(double) + 3 + 3 * sizeof(float);
  constexpr std::size_t kFace = 1 + 3 * sizeof(std::uint32_t);
  EXPECT_EQ(ply.size(), ply.find(end) + end.size() + kVertex * count("element vertex ") +
                            kFace * count("element face "));
}

TEST(Export, CsvRowsAreTheLeavesAndProbeReadsThem) {
  const Folder folder;
  ASSERT_EQ(run({"export", furnace_run(), "-o", folder / "cube.csv"}).code, 0);
  std::istringstream lines(read_file(folder / "cube.csv"));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "cluster,patch,x,y,z,nx,ny,nz,area,Er,Eg,Eb,Br,Bg,Bb");
  double area = 0;
  std::size_t rows = 0;
  while (std::getline(lines, line)) {
    ++rows;
    std::istringstream fields(line);
    std::string field;
    for (int i = 0; i < 9; ++i) std::getline(fields, field, ',');
    area += std::stod(field);
    std::getline(fields, field, ',');
    EXPECT_NEAR(std::stod(field), kFurnaceRadiosity, kTolerance);
  }
  EXPECT_NEAR(area, kCubeArea, 1e-12 * kCubeArea);
  const Ended probed = run({"probe", furnace_run(), folder / "cube.csv"});
  ASSERT_EQ(probed.code, 0) << probed.err;
  EXPECT_EQ(probed.out.find("-1,-1\n"), std::string::npos);
  EXPECT_EQ(static_cast<std::size_t>(std::count(probed.out.begin(), probed.out.end(), '\n')),
            rows + 1);
}

}  // namespace
}  // namespace atrium::testing
