#include <cstring>
#include <numbers>

#include "test/engine/import_fixture.h"

namespace atrium {
namespace {

// A unit square of four vertices and two triangles, facing up.
const float kSquare[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
const std::uint16_t kIndices[6] = {0, 1, 2, 0, 2, 3};

struct GltfText {
  std::string nodes = R"([{"mesh":0,"name":"quad"}])";
  std::string materials =
      R"([{"name":"m","pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1]}}])";
  std::string primitive = R"({"attributes":{"POSITION":0},"indices":1,"material":0})";
  std::string extra;  // further members of the root
  int vertex_count = 4;
  int index_count = 6;
  std::vector<float> positions{kSquare, kSquare + 12};
  std::vector<std::uint16_t> indices{kIndices, kIndices + 6};

  std::string binary() const {
    std::string b(positions.size() * sizeof(float) + indices.size() * sizeof(std::uint16_t), '\0');
    std::memcpy(b.data(), positions.data(), positions.size() * sizeof(float));
    std::memcpy(b.data() + positions.size() * sizeof(float), indices.data(),
                indices.size() * sizeof(std::uint16_t));
    return b;
  }
  std::string json() const {
    const std::size_t split = positions.size() * sizeof(float);
    const auto n = [](std::size_t x) { return std::to_string(x); };
    std::string roots;
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":)" + nodes +
           R"(,"materials":)" + materials + R"(,"meshes":[{"primitives":[)" + primitive +
           R"(]}],"accessors":[{"bufferView":0,"componentType":5126,"count":)" +
           std::to_string(vertex_count) +
           R"(,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},{"bufferView":1,"componentType":5123,"count":)" +
           std::to_string(index_count) +
           R"(,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":)" +
           n(split) + R"(},{"buffer":0,"byteOffset":)" + n(split) + R"(,"byteLength":)" +
           n(binary().size() - split) + R"(}],"buffers":[{"byteLength":)" + n(binary().size()) +
           "}]" + extra + "}";
  }
  std::string glb() const {
    std::string text = json(), data = binary();
    while (text.size() % 4) text += ' ';
    while (data.size() % 4) data += '\0';
    const auto word = [](std::size_t x) {
      const auto v = static_cast<std::uint32_t>(x);
      std::string s(4, '\0');
      std::memcpy(s.data(), &v, 4);
      return s;
    };
    return "glTF" + word(2) + word(12 + 8 + text.size() + 8 + data.size()) + word(text.size()) +
           "JSON" + text + word(data.size()) + std::string("BIN\0", 4) + data;
  }
};

class ImportGltf : public ImportTest {
 protected:
  Result<Scene> import_glb(const GltfText& text) { return import_bytes(text.glb()); }
  Result<Scene> import_bytes(const std::string& bytes) {
    options_.files = {write("scene.glb", bytes)};
    return import_scene(options_);
  }
  void expect_broken(const GltfText& text, const std::string& place) {
    const auto scene = import_glb(text);
    ASSERT_FALSE(scene.ok()) << place;
    EXPECT_EQ(scene.status().code(), Code::kScene);
    EXPECT_NE(scene.status().place().find(place), std::string::npos) << scene.status().message();
  }
};

TEST_F(ImportGltf, ASquareIsOneQuad) {
  const auto scene = import_glb({});
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  ASSERT_EQ(scene->surfaces.size(), 1u);
  EXPECT_EQ(scene->surfaces[0].vertex_count, 4u);
  EXPECT_EQ(scene->objects[0].name, "quad");
  EXPECT_EQ(scene->polygons, 2u);
  EXPECT_EQ(scene->materials[0].reflectance, Spectrum(0.5, 0.25, 0.9));
  EXPECT_GT(area_vector(scene->polygon(scene->surfaces[0])).z, 0);
}

TEST_F(ImportGltf, NodesCarryTheirTransforms) {
  GltfText text;
  // Scaled by 2 in x, turned by 90 degrees about z, moved; under a parent moved by 10 in z.
  text.nodes = R"([{"children":[1],"translation":[0,0,10]},
      {"mesh":0,"name":"q","scale":[2,1,1],"rotation":[0,0,0.70710678118654752,0.70710678118654752],
       "translation":[5,0,0]}])";
  const auto scene = import_glb(text);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  const Box box = inspect(*scene).bounds;
  EXPECT_NEAR(length(box.lo - Vec3(4, 0, 10)), 0, 1e-6);
  EXPECT_NEAR(length(box.hi - Vec3(5, 2, 10)), 0, 1e-6);
}

TEST_F(ImportGltf, MirroredNodesKeepTheirFronts) {
  GltfText text;
  text.nodes = R"([{"mesh":0,"scale":[-1,1,1]}])";
  const auto scene = import_glb(text);
  ASSERT_TRUE(scene.ok());
  EXPECT_GT(area_vector(scene->polygon(scene->surfaces[0])).z, 0);
  text.nodes = R"([{"mesh":0,"matrix":[1,0,0,0,0,-1,0,0,0,0,1,0,0,0,0,1]}])";
  EXPECT_GT(area_vector(import_glb(text)->polygon(import_glb(text)->surfaces[0])).z, 0);
}

TEST_F(ImportGltf, EmissionIsFactorTimesStrength) {
  GltfText text;
  text.materials = R"([{"name":"lamp","emissiveFactor":[1,0.5,0.25],
      "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":400}}}])";
  const auto scene = import_glb(text);
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->materials[0].exitance, std::numbers::pi * Spectrum(400, 200, 100));
  EXPECT_EQ(scene->lights, 1u);
}

TEST_F(ImportGltf, AlphaCountsOnlyWhereItIsUsed) {
  GltfText text;
  text.materials =
      R"([{"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.2]}}])";
  EXPECT_EQ(import_glb(text).status().code(), Code::kScene) << "nothing but clear glass is left";
  text.materials = R"([{"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.2]}}])";
  EXPECT_TRUE(import_glb(text).ok());
}

TEST_F(ImportGltf, DoubleSidedShellsShowBoth) {
  GltfText text;
  text.materials = R"([{"doubleSided":true}])";
  EXPECT_EQ(import_glb(text)->surfaces[0].sides, kBothSides);
  options_.sides = SidesChoice::kOne;
  EXPECT_EQ(import_glb(text)->surfaces[0].sides, kFront);
}

TEST_F(ImportGltf, StripsAndFansFaceOneWay) {
  GltfText text;
  text.indices = {0, 1, 3, 2, 0, 0};
  text.index_count = 4;
  text.primitive = R"({"attributes":{"POSITION":0},"indices":1,"mode":5})";
  auto scene = import_glb(text);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->surfaces.size(), 1u);
  text.indices = {0, 1, 2, 3, 0, 0};
  text.primitive = R"({"attributes":{"POSITION":0},"indices":1,"mode":6})";
  scene = import_glb(text);
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->surfaces.size(), 1u);
}

TEST_F(ImportGltf, WhatIsBrokenIsNamed) {
  GltfText text;
  text.indices[3] = 4;
  expect_broken(text, "accessors[1], index 3");
  text = {};
  text.vertex_count = 5;
  expect_broken(text, "accessors[0]");
  text = {};
  text.positions[4] = std::numeric_limits<float>::quiet_NaN();
  expect_broken(text, "accessors[0], vertex 1");
  text = {};
  text.primitive = R"({"attributes":{"POSITION":7},"indices":1})";
  expect_broken(text, "accessors[7]");
  text = {};
  text.primitive = R"({"attributes":{"POSITION":1},"indices":0})";
  expect_broken(text, "accessors[1]");
  text = {};
  text.primitive = R"({"attributes":{"POSITION":0},"indices":1,"material":3})";
  expect_broken(text, "primitives[0]");
  text = {};
  text.nodes = R"([{"mesh":2}])";
  expect_broken(text, "nodes[0]");
  text = {};
  text.nodes = R"([{"mesh":0,"children":[0]}])";
  expect_broken(text, "nodes[0]");
  text = {};
  text.extra = R"(,"extensionsRequired":["KHR_draco_mesh_compression"])";
  expect_broken(text, "extensionsRequired");
  text = {};
  text.materials = R"([{"name":"bright","pbrMetallicRoughness":{"baseColorFactor":[1.5,0,0,1]}}])";
  expect_broken(text, "'bright'");
}

TEST_F(ImportGltf, ATruncatedFileIsRefusedAtEveryLength) {
  const std::string whole = GltfText().glb();
  ASSERT_TRUE(import_bytes(whole).ok());
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    const auto scene = import_bytes(whole.substr(0, length));
    ASSERT_FALSE(scene.ok()) << length;
    EXPECT_EQ(scene.status().code(), Code::kScene) << length;
    EXPECT_FALSE(scene.status().place().empty()) << length;
  }
}

TEST_F(ImportGltf, AnyByteMayBeDamaged) {
  // Whatever one damaged byte makes of the file, it is a scene or a named error.
  const std::string whole = GltfText().glb();
  for (std::size_t at = 0; at < whole.size(); at += 3) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x15);
    const auto scene = import_bytes(damaged);
    if (!scene.ok()) {
      EXPECT_EQ(scene.status().code(), Code::kScene) << at;
    }
  }
}

TEST_F(ImportGltf, TextFilesWithBuffersBesideThem) {
  GltfText text;
  write("square.bin", text.binary());
  std::string json = text.json();
  const std::string length = R"("buffers":[{)";
  json.insert(json.find(length) + length.size(), R"("uri":"square.bin",)");
  options_.files = {write("scene.gltf", json)};
  const auto scene = import_scene(options_);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->patches, 1u);
  std::filesystem::remove(folder_ / "square.bin");
  EXPECT_EQ(import_scene(options_).status().code(), Code::kScene);
}

}  // namespace
}  // namespace atrium
