#include <numbers>

#include "test/engine/import_fixture.h"

namespace atrium {
namespace {

class ImportAssign : public ImportTest {
 protected:
  Result<Scene> with_rules(const std::string& toml) {
    write("m.mtl", "newmtl wall paint\nKd 0.5\nnewmtl glow\nKd 0.2\nKe 50\n");
    options_.assign_file = write("assign.toml", toml);
    return import("mtllib m.mtl\n" + std::string(ObjText()
                                                     .object("wall")
                                                     .material("wall paint")
                                                     .floor(0, 0, 1, 1)
                                                     .object("lamp_1")
                                                     .material("wall paint")
                                                     .floor(2, 0, 3, 1)
                                                     .object("lamp_2")
                                                     .material("glow")
                                                     .floor(4, 0, 5, 1)));
  }
  static const Material& material_of(const Scene& scene, std::size_t surface) {
    return scene.materials[scene.surfaces[surface].material.value];
  }
};

TEST_F(ImportAssign, MaterialsByName) {
  const auto scene = with_rules("[[material]]\nmatch = \"wall*\"\nreflectance = [0.1, 0.2, 0.3]\n");
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(material_of(*scene, 0).reflectance, Spectrum(0.1, 0.2, 0.3));
  EXPECT_EQ(material_of(*scene, 1).reflectance, Spectrum(0.1, 0.2, 0.3));
  EXPECT_EQ(material_of(*scene, 2).reflectance, Spectrum(0.2));
}

TEST_F(ImportAssign, ObjectsByNameGetMaterialsOfTheirOwn) {
  const auto scene = with_rules("[[material]]\nmatch = \"lamp_*\"\nemission = 1000\nsides = 1\n");
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_FALSE(material_of(*scene, 0).emits());
  EXPECT_EQ(material_of(*scene, 1).exitance, Spectrum(1000 * std::numbers::pi));
  EXPECT_EQ(material_of(*scene, 1).reflectance, Spectrum(0.5));
  EXPECT_EQ(material_of(*scene, 2).exitance, Spectrum(1000 * std::numbers::pi));
  EXPECT_EQ(scene->surfaces[0].sides, kBothSides);
  EXPECT_EQ(scene->surfaces[1].sides, kFront);
  EXPECT_EQ(scene->lights, 2u);
}

TEST_F(ImportAssign, LaterRulesStandAboveEarlierOnes) {
  const auto scene = with_rules(
      "[[material]]\nmatch = \"lamp_1\"\nreflectance = 0.7\nemission = 5\n"
      "[[material]]\nmatch = \"wall paint\"\nreflectance = 0.3\n");
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(material_of(*scene, 1).reflectance, Spectrum(0.3));
  EXPECT_EQ(material_of(*scene, 1).exitance, Spectrum(5 * std::numbers::pi));
  EXPECT_EQ(material_of(*scene, 0).exitance, Spectrum(0));
}

TEST_F(ImportAssign, AssignedEmissionIsLuminanceWhateverKeIs) {
  options_.emission_is_exitance = true;
  const auto scene = with_rules("[[material]]\nmatch = \"lamp_1\"\nemission = 5\n");
  EXPECT_EQ(material_of(*scene, 1).exitance, Spectrum(5 * std::numbers::pi));
  EXPECT_EQ(material_of(*scene, 2).exitance, Spectrum(50));
}

TEST_F(ImportAssign, ObjectsAreDroppedByGlob) {
  const auto scene = with_rules("[[object]]\nmatch = \"lamp_?\"\ndrop = true\n");
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->patches, 1u);
}

TEST_F(ImportAssign, WhitePaintRuleHoldsForAssignedOnesToo) {
  const auto scene = with_rules("[[material]]\nmatch = \"wall*\"\nreflectance = 1\n");
  EXPECT_EQ(material_of(*scene, 0).reflectance, Spectrum(0.9));
}

TEST_F(ImportAssign, NamesThatMatchNothingAreWarnedOf) {
  const auto scene = with_rules("[[material]]\nmatch = \"wal\"\nreflectance = 0.1\n");
  ASSERT_TRUE(scene.ok());
  EXPECT_NE(warning(*scene, "match nothing"), nullptr);
}

TEST_F(ImportAssign, WrongFilesAreUsageErrorsWithTheirLine) {
  const std::pair<const char*, const char*> cases[] = {
      {"[[material]]\nmatch = \"a\"\nreflektance = 0.5\n", "line 3"},
      {"[[materials]]\nmatch = \"a\"\n", "line 1"},
      {"[[material]]\nreflectance = 0.5\n", "line 1"},
      {"[[material]]\nmatch = \"a\"\n", "line 1"},
      {"[[material]]\nmatch = \"a\"\nreflectance = 1.5\n", "line 3"},
      {"[[material]]\nmatch = \"a\"\nreflectance = nan\n", "line 3"},
      {"[[material]]\nmatch = \"a\"\nemission = -1\n", "line 3"},
      {"[[material]]\nmatch = \"a\"\nemission = inf\n", "line 3"},
      {"[[material]]\nmatch = \"a\"\nreflectance = [0.1, 0.2]\n", "line 3"},
      {"[[material]]\nmatch = \"a\"\nreflectance = \"red\"\n", "line 3"},
      {"[[material]]\nmatch = \"a\"\nsides = 3\n", "line 3"},
      {"[[material]]\nmatch = 7\nsides = 1\n", "line 2"},
      {"[[object]]\nmatch = \"a\"\n", "line 1"},
      {"[[object]]\nmatch = \"a\"\ndrop = 1\n", "line 3"},
      {"[material]\nmatch = \"a\"\n", "line 1"},
      {"match = \n", "line 1"},
  };
  for (const auto& [toml, place] : cases) {
    const auto scene = with_rules(toml);
    ASSERT_FALSE(scene.ok()) << toml;
    EXPECT_EQ(scene.status().code(), Code::kUsage) << toml;
    EXPECT_EQ(scene.status().place(), place) << toml << scene.status().message();
    EXPECT_EQ(scene.status().file(), options_.assign_file);
  }
  options_.assign_file = (folder_ / "missing.toml").string();
  EXPECT_EQ(import(ObjText().floor(0, 0, 1, 1)).status().code(), Code::kUsage);
}

}  // namespace
}  // namespace atrium
