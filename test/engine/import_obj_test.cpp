#include <cmath>
#include <numbers>

#include "test/engine/import_fixture.h"

namespace atrium {
namespace {

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

class ImportObj : public ImportTest {
 protected:
  void expect_broken(const std::string& obj, const std::string& place, const std::string& cause) {
    const Result<Scene> scene = import(obj);
    ASSERT_FALSE(scene.ok()) << obj;
    EXPECT_EQ(scene.status().code(), Code::kScene);
    EXPECT_EQ(scene.status().file(), options_.files[0]);
    EXPECT_EQ(scene.status().place(), place);
    EXPECT_NE(scene.status().cause().find(cause), std::string::npos) << scene.status().cause();
    EXPECT_FALSE(scene.status().remedy().empty());
  }
  Result<Scene> with_material(const std::string& mtl) {
    write("m.mtl", mtl);
    return import("mtllib m.mtl\n" + kTriangle + "usemtl m\nf 1 2 3\n");
  }
};

TEST_F(ImportObj, BrokenLinesAreNamed) {
  expect_broken("v 0 0 nan\n", "line 1", "'nan' is not a finite number");
  expect_broken("v 0 0 1\nv 0 0 inf\n", "line 2", "'inf'");
  expect_broken("v 0 0 1e999\n", "line 1", "'1e999'");
  expect_broken("v 0 0 1x\n", "line 1", "'1x'");
  expect_broken("# one\n\nv 0 0\n", "line 3", "2 numbers");
  expect_broken(kTriangle + "f\n", "line 4", "0 corners");
  expect_broken(kTriangle + "f 1 2", "line 4", "2 corners");
  expect_broken(kTriangle + "f 1 2 4\n", "line 4", "corner 4 is out of range");
  expect_broken(kTriangle + "f 1 2 -4\n", "line 4", "before the first vertex");
  expect_broken(kTriangle + "f 1 2 0\n", "line 4", "'0' is no corner");
  expect_broken(kTriangle + "f 1 2 3x\n", "line 4", "'3x' is no corner");
  expect_broken(kTriangle + "f 1/ 2 3\n", "line 4", "'1/' is no corner");
  expect_broken(kTriangle + "f 1 2 3\n\x01\x02 binary\n", "line 5", "no OBJ statement");
}

TEST_F(ImportObj, FilesWithoutSurfacesAreRefused) {
  expect_broken("", "", "holds no faces");
  expect_broken(kTriangle, "", "holds no faces");
  options_.files = {(folder_ / "missing.obj").string()};
  EXPECT_EQ(import_scene(options_).status().code(), Code::kScene);
  options_.files = {write("scene.3ds", "x")};
  EXPECT_EQ(import_scene(options_).status().code(), Code::kScene);
  options_.files = {folder_.string() + "/"};
  EXPECT_EQ(import_scene(options_).status().code(), Code::kScene);
  options_.files.clear();
  EXPECT_EQ(import_scene(options_).status().code(), Code::kUsage);
}

TEST_F(ImportObj, AllFormsOfCornersReadTheSame) {
  const Scene scene =
      imported(kTriangle +
               "vt 0 0\nvn 0 0 1\nf 1/1 2/1 3/1\no b\nv 0 0 1\nv 1 0 1\nv 0 1 1\n"
               "f -3//1 -2//1 \\\n -1//1\no c\nv 0 0 2 1 1 1\nf 1/1/1 2/1/1 7/1/1\n");
  EXPECT_EQ(scene.polygons, 3u);
  EXPECT_EQ(scene.patches, 3u);
  EXPECT_NEAR(area_of(scene, kFront), 0.5 + 0.5 + 1.0, 1e-12);
  EXPECT_EQ(scene.objects.size(), 3u);
}

TEST_F(ImportObj, VerticesMayFollowTheirFaces) {
  EXPECT_EQ(imported("f 1 2 3\n" + kTriangle).patches, 1u);
}

TEST_F(ImportObj, ConsecutiveBlocksOfOneNameAreOneObject) {
  const Scene scene = imported(ObjText()
                                   .object("desk")
                                   .floor(0, 0, 1, 1)
                                   .object("desk")
                                   .floor(0, 0, 1, 1, 1)
                                   .object("lamp")
                                   .floor(0, 0, 1, 1, 2)
                                   .object("desk")
                                   .floor(0, 0, 1, 1, 3));
  ASSERT_EQ(scene.objects.size(), 3u);
  EXPECT_EQ(scene.objects[0].name, "desk");
  EXPECT_EQ(scene.objects[1].name, "lamp");
  EXPECT_EQ(scene.objects[2].name, "desk");
}

TEST_F(ImportObj, GroupsAreObjectsOnlyWithoutObjects) {
  EXPECT_EQ(imported(kTriangle + "g a\nf 1 2 3\ng b\nf 3 2 1\n").objects.size(), 2u);
  EXPECT_EQ(imported(kTriangle + "o x\ng a\nf 1 2 3\ng b\nf 3 2 1\n").objects.size(), 1u);
}

TEST_F(ImportObj, NamelessFilesFallIntoConnectedParts) {
  const Scene scene = imported(ObjText()
                                   .floor(0, 0, 1, 1)
                                   .floor(5, 0, 6, 1)
                                   .face({{1, 0, 0}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0}}));
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.objects[0].name, "scene part 1");
  ASSERT_EQ(scene.surfaces.size(), 3u);
  EXPECT_EQ(scene.surfaces[0].object, scene.surfaces[1].object);
  EXPECT_NE(scene.surfaces[0].object, scene.surfaces[2].object);
}

TEST_F(ImportObj, LuminanceBecomesExitance) {
  const auto scene = with_material("newmtl m\nKd 0.5 0.25 0.125\nKe 300 200 100\n");
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->materials[0].exitance, std::numbers::pi * Spectrum(300, 200, 100));
  EXPECT_EQ(scene->materials[0].reflectance, Spectrum(0.5, 0.25, 0.125));
  EXPECT_EQ(scene->lights, 1u);
  // One triangle of half a square metre that emits from both sides.
  const double m = std::numbers::pi * (0.2126 * 300 + 0.7152 * 200 + 0.0722 * 100);
  EXPECT_NEAR(inspect(*scene).lumens, m * 0.5 * 2, 1e-9 * m);
  options_.emission_is_exitance = true;
  EXPECT_EQ(with_material("newmtl m\nKe 300 200 100\n")->materials[0].exitance,
            Spectrum(300, 200, 100));
}

TEST_F(ImportObj, ExactlyOneIsWhitePaintAndNothingElseIs) {
  const auto scene = with_material("newmtl m\nKd 1 0.99999 0\n");
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->materials[0].reflectance, Spectrum(0.9, 0.99999, 0));
  const Warning* w = warning(*scene, "exactly 1");
  ASSERT_NE(w, nullptr);
  EXPECT_NE(w->examples[0].find("'m'"), std::string::npos);
  options_.white = 0.8;
  EXPECT_EQ(with_material("newmtl m\nKd 1\n")->materials[0].reflectance, Spectrum(0.8));
  options_.white = 1;
  EXPECT_EQ(with_material("newmtl m\nKd 1\n").status().code(), Code::kUsage);
}

TEST_F(ImportObj, ImpossibleMaterialsAreRefusedByName) {
  for (const char* line : {"Kd 1.0001 0 0", "Kd -0.1 0 0", "Kd nan 0 0", "Kd inf 0 0", "Ke -1 0 0",
                           "Ke nan 0 0", "Ke 1e999 0 0"}) {
    const auto scene = with_material(std::string("newmtl m\n") + line + "\n");
    ASSERT_FALSE(scene.ok()) << line;
    EXPECT_EQ(scene.status().code(), Code::kScene);
    EXPECT_NE(scene.status().place().find("'m'"), std::string::npos);
    EXPECT_NE(scene.status().file().find("m.mtl"), std::string::npos);
  }
  for (const char* line : {"Kd 0.5 0.5", "Kd spectral x.rfl", "d 2", "d -1", "d nan", "Kd"}) {
    const auto scene = with_material(std::string("newmtl m\n") + line + "\n");
    ASSERT_FALSE(scene.ok()) << line;
    EXPECT_EQ(scene.status().place(), "line 2, material 'm'");
  }
}

TEST_F(ImportObj, ClearGlassIsLeftOutOfTheWay) {
  write("m.mtl",
        "newmtl pane\nKd 1 1 1\nd 0.49\nnewmtl milk\nKd 0.5 0.5 0.5\nd 0.5\nnewmtl tr\nTr 0.6\n");
  const Scene scene = imported("mtllib m.mtl\n" + kTriangle +
                               "o a\nusemtl pane\nf 1 2 3\no b\nusemtl milk\nf 3 2 1\n"
                               "o c\nusemtl tr\nf 3 2 1\n");
  EXPECT_EQ(scene.polygons, 3u);
  EXPECT_EQ(scene.patches, 1u);
  const Warning* w = warning(scene, "clear glass");
  ASSERT_NE(w, nullptr);
  EXPECT_EQ(w->count, 2u);
  EXPECT_NE(w->examples[0].find("'pane'"), std::string::npos);
}

TEST_F(ImportObj, FacesWithoutAMaterialAreGreyAndWarnedOf) {
  const Scene none = imported(kTriangle + "f 1 2 3\n");
  EXPECT_EQ(none.materials[0].reflectance, Spectrum(0.5));
  EXPECT_NE(warning(none, "without a material"), nullptr);
  const Scene undefined = imported("mtllib none.mtl\n" + kTriangle + "usemtl ghost\nf 1 2 3\n");
  EXPECT_EQ(undefined.materials[0].name, "ghost");
  EXPECT_EQ(undefined.materials[0].reflectance, Spectrum(0.5));
  EXPECT_NE(warning(undefined, "libraries not found"), nullptr);
  EXPECT_NE(warning(undefined, "no library defines"), nullptr);
}

TEST_F(ImportObj, TexturesAndDimLampsAreWarnedOf) {
  const auto scene = with_material("newmtl m\nKd 0.5\nmap_Kd wood.png\nKe 15\n");
  EXPECT_NE(warning(*scene, "textures ignored"), nullptr);
  EXPECT_NE(warning(*scene, "below 100 cd/m²"), nullptr);
  EXPECT_EQ(warning(*with_material("newmtl m\nKe 150\n"), "below 100 cd/m²"), nullptr);
}

TEST_F(ImportObj, EqualNamesInDifferentFilesStayApart) {
  write("a.mtl", "newmtl m\nKd 0.25\n");
  write("b.mtl", "newmtl m\nKd 0.75\n");
  options_.files = {
      write("a.obj", "mtllib a.mtl\n" + kTriangle + "o x\nusemtl m\nf 1 2 3\n"),
      write("b.obj", "mtllib b.mtl\nv 0 0 1\nv 1 0 1\nv 0 1 1\no x\nusemtl m\nf 1 2 3\n")};
  const auto scene = import_scene(options_);
  ASSERT_TRUE(scene.ok());
  ASSERT_EQ(scene->surfaces.size(), 2u);
  EXPECT_EQ(scene->materials[scene->surfaces[0].material.value].reflectance.x, 0.25);
  EXPECT_EQ(scene->materials[scene->surfaces[1].material.value].reflectance.x, 0.75);
  EXPECT_EQ(scene->objects.size(), 2u);
}

TEST_F(ImportObj, DegenerateFacesAreDroppedAndNamed) {
  const Scene scene =
      imported(kTriangle + "v 0.5 0 0\no x\nf 1 2 3\nf 1 4 2\nf 1 1 2\nf 1 2 1\nf 1 2\n");
  EXPECT_EQ(scene.polygons, 5u);
  EXPECT_EQ(scene.patches, 1u);
  const Warning* w = warning(scene, "degenerate");
  ASSERT_NE(w, nullptr);
  EXPECT_EQ(w->count, 4u);
  EXPECT_EQ(w->examples[0], "object 'x', line 7");
}

TEST_F(ImportObj, ANonPlanarQuadFallsAlongItsSecondAndFourthCorner) {
  const Scene scene = imported("v 0 0 0\nv 1 0 0.1\nv 1 1 0\nv 0 1 0.1\no x\nf 1 2 3 4\n");
  ASSERT_EQ(scene.surfaces.size(), 2u);
  EXPECT_NE(warning(scene, "not planar"), nullptr);
  for (const Surface& s : scene.surfaces) {
    int on_diagonal = 0;
    for (const Vec3& x : scene.polygon(s)) on_diagonal += std::abs(x.z - 0.1) < 1e-9;
    EXPECT_EQ(on_diagonal, 2) << "corners 2 and 4 belong to both triangles";
  }
}

TEST_F(ImportObj, ANonPlanarDartFallsWhereItCan) {
  // Corner 3 is reflex and lies within the triangle 4, 1, 2: only the diagonal 1-3 is inside.
  const Scene scene = imported("v 0 0 0\nv 4 0 0.1\nv 1 1 0\nv 0 4 0.1\no x\nf 1 2 3 4\n");
  ASSERT_EQ(scene.surfaces.size(), 2u);
  const double tall = area(Polygon{{0, 0, 0}, {4, 0, 0.1}, {1, 1, 0}});
  EXPECT_NEAR(area_of(scene, kFront), 2 * tall, 1e-9);
}

TEST_F(ImportObj, ConcaveFacesFallIntoConvexPieces) {
  // An L of three unit squares.
  const Scene scene = imported(ObjText().object("x").face(
      {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}));
  expect_sound(scene);
  EXPECT_EQ(scene.surfaces.size(), 2u);
  EXPECT_NEAR(area_of(scene, kFront), 3, 1e-12);
}

TEST_F(ImportObj, AKeyholedFaceKeepsItsHole) {
  const Scene scene = imported(ObjText().object("x").face({{0, 0, 0},
                                                           {4, 0, 0},
                                                           {4, 4, 0},
                                                           {0, 4, 0},
                                                           {0, 0, 0},
                                                           {1, 1, 0},
                                                           {1, 3, 0},
                                                           {3, 3, 0},
                                                           {3, 1, 0},
                                                           {1, 1, 0}}));
  expect_sound(scene);
  EXPECT_NEAR(area_of(scene, kFront), 12, 1e-9);
  EXPECT_EQ(scene.surfaces.size(), 4u);
  for (const Surface& s : scene.surfaces)
    EXPECT_FALSE(contains(scene.polygon(s), {0, 0, 1}, Vec3{2, 2, 0}, 0));
}

TEST_F(ImportObj, DropIsSearchedForInNames) {
  options_.drop = {"^DOOR_", "no such"};
  const Scene scene = imported(
      ObjText().object("DOOR_12").floor(0, 0, 1, 1).object("wall by DOOR_12").floor(0, 0, 1, 1, 1));
  EXPECT_EQ(scene.patches, 1u);
  EXPECT_EQ(scene.polygons, 2u);
  EXPECT_EQ(warning(scene, "dropped as asked")->examples[0], "'DOOR_12'");
  EXPECT_NE(warning(scene, "match no object"), nullptr);
  options_.drop = {"("};
  EXPECT_EQ(import(ObjText().floor(0, 0, 1, 1)).status().code(), Code::kUsage);
  options_.drop = {"."};
  EXPECT_EQ(import(ObjText().floor(0, 0, 1, 1)).status().code(), Code::kScene);
}

TEST_F(ImportObj, UnitsScaleToMetres) {
  options_.unit = 0.0254;
  const Scene scene = imported(ObjText().object("x").floor(100, 200, 110, 220));
  EXPECT_NEAR(area_of(scene, kFront), 10 * 20 * 0.0254 * 0.0254, 1e-12);
  const SceneReport report = inspect(scene);
  EXPECT_NEAR(report.bounds.lo.x, 100 * 0.0254, 1e-12);
  EXPECT_NEAR(report.bounds.hi.y, 220 * 0.0254, 1e-12);
  const Vec3 corner = scene.polygon(scene.surfaces[0])[0];
  EXPECT_NEAR(length(scene.frame.to_internal({100, 200, 0}) - corner), 0, 1e-12);
  for (const double bad : {0.0, -1.0, std::nan("")}) {
    options_.unit = bad;
    EXPECT_EQ(import(ObjText().floor(0, 0, 1, 1)).status().code(), Code::kUsage);
  }
}

}  // namespace
}  // namespace atrium
