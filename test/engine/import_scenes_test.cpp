// The real scenes of ../shared, each loaded whole; skipped where they are missing.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "engine/import/import.h"
#include "engine/import/inspect.h"

namespace atrium {
namespace {

struct RealScene {
  const char* name;
  std::vector<std::string> files;
  std::uint64_t polygons;
  std::uint64_t most_patches;
};

void PrintTo(const RealScene& s, std::ostream* out) { *out << s.name; }

class ImportRealScene : public testing::TestWithParam<RealScene> {
 protected:
  // m² of the faces of an OBJ file as they stand there. One that is not planar counts by the
  // triangles that clipping its first corners leaves, all of them at its last corner.
  static double area_in_file(const std::string& path, double tolerance) {
    std::ifstream in(path);
    std::vector<Vec3> vertices;
    double sum = 0;
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      std::string word;
      words >> word;
      if (word == "v") {
        Vec3 x;
        words >> x.x >> x.y >> x.z;
        vertices.push_back(x);
      } else if (word == "f") {
        Polygon p;
        for (std::string corner; words >> corner;) {
          const long i = std::stol(corner);
          p.push_back(
              vertices[static_cast<std::size_t>(i < 0 ? long(vertices.size()) + i : i - 1)]);
        }
        if (planarity(p) <= tolerance) {
          sum += area(p);
          continue;
        }
        for (std::size_t i = 1; i + 1 < p.size(); ++i)
          sum += area(Polygon{p.back(), p[i - 1], p[i]});
      }
    }
    return sum;
  }
};

TEST_P(ImportRealScene, LoadsWithSaneCountsAndSoundSurfaces) {
  const RealScene& s = GetParam();
  ImportOptions options;
  for (const std::string& f : s.files) {
    options.files.push_back(std::string(ATRIUM_SHARED_DIR) + "/scenes/" + f);
    if (!std::filesystem::exists(options.files.back()))
      GTEST_SKIP() << options.files.back() << " is missing";
  }
  const Result<Scene> scene = import_scene(options);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->polygons, s.polygons);
  EXPECT_LE(scene->patches, s.most_patches);
  EXPECT_GT(scene->patches, s.polygons / 50);
  std::size_t bent = 0, dented = 0;
  for (const Surface& f : scene->surfaces) {
    bent += planarity(scene->polygon(f)) > scene->tolerance;
    dented += !is_convex(scene->polygon(f), scene->tolerance);
  }
  EXPECT_EQ(bent, 0u);
  EXPECT_EQ(dented, 0u);
  // Area: what the files have, less what is left out or overlaps. Without either, all of it.
  double before = 0;
  for (const std::string& f : options.files)
    if (f.ends_with(".obj")) before += area_in_file(f, scene->tolerance);
  const SceneReport report = inspect(*scene);
  if (before > 0) {
    EXPECT_LE(report.area, before * (1 + 1e-6));
  }
  bool less = before == 0;
  for (const Warning& w : scene->warnings)
    less |= w.what.find("glass") != std::string::npos || w.what.find("cut") != std::string::npos ||
            w.what.find("duplicate") != std::string::npos ||
            w.what.find("covered") != std::string::npos;
  if (!less) {
    EXPECT_NEAR(report.area, before, 1e-6 * before);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Shared, ImportRealScene,
    testing::Values(RealScene{"cornell_box", {"cornell_box/CornellBox-Original.obj"}, 18, 18},
                    RealScene{"veach_ajar", {"veach_ajar/veach_ajar.obj"}, 4545, 4545},
                    RealScene{"mgf_office2", {"mgf_office2/office2.obj"}, 422, 500},
                    RealScene{"mgf_office3", {"mgf_office3/office3.obj"}, 7466, 9000},
                    RealScene{"mgf_classroom", {"mgf_classroom/classroom.obj"}, 5250, 6500},
                    RealScene{"mgf_corridor", {"mgf_corridor/corridor.obj"}, 291, 350},
                    RealScene{"mgf_hospital", {"mgf_hospital/hospital.obj"}, 7591, 9000},
                    RealScene{
                        "duplex", {"duplex/duplex.obj", "duplex/duplex.lamps.obj"}, 39380, 28000},
                    RealScene{"whale_large",
                              {"whale_large/whale_large.obj", "whale_large/whale_large.lamps.obj"},
                              35530,
                              18000},
                    RealScene{"institute",
                              {"institute/institute.obj", "institute/institute.lamps.obj"},
                              41792,
                              20000},
                    RealScene{"pandora", {"pandora/pandora.obj"}, 60810, 25000},
                    RealScene{"godot_room", {"godot_room/room.glb"}, 63720, 40000},
                    RealScene{"godot_living_room", {"godot_room/living_room.glb"}, 5088, 1000}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace atrium
