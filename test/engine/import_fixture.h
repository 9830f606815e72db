// Tiny scenes written to a folder of the test's own, imported, and looked at.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "engine/import/import.h"
#include "engine/import/inspect.h"

namespace atrium {

class ImportTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("atrium_") + info->test_suite_name() + "_" + info->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

  // Imports an OBJ of this text; options as set up by the test.
  Result<Scene> import(const std::string& obj) {
    options_.files = {write("scene.obj", obj)};
    return import_scene(options_);
  }
  Scene imported(const std::string& obj) {
    Result<Scene> scene = import(obj);
    if (!scene.ok()) ADD_FAILURE() << scene.status().message();
    return scene.ok() ? *scene : Scene{};
  }

  static const Warning* warning(const Scene& scene, const std::string& what) {
    for (const Warning& w : scene.warnings)
      if (w.what.find(what) != std::string::npos) return &w;
    return nullptr;
  }

  // m² of the surfaces on which the side counts.
  static double area_of(const Scene& scene, Sides side) {
    double sum = 0;
    for (const Surface& s : scene.surfaces)
      if (s.sides & side) sum += area(scene.polygon(s));
    return sum;
  }

  static void expect_sound(const Scene& scene) {
    for (const Surface& s : scene.surfaces) {
      const PolygonView p = scene.polygon(s);
      EXPECT_GE(p.size(), 3u);
      EXPECT_TRUE(is_convex(p, scene.tolerance));
      EXPECT_LE(planarity(p), scene.tolerance);
      EXPECT_GT(area(p), scene.tolerance * scene.tolerance);
      EXPECT_NE(s.sides, kNoSide);
      EXPECT_LT(s.object.value, scene.objects.size());
      EXPECT_LT(s.material.value, scene.materials.size());
    }
  }

  std::filesystem::path folder_;
  ImportOptions options_;
};

// OBJ text made piece by piece; corners are given as points, shared by position.
class ObjText {
 public:
  double scale = 1;
  Vec3 shift{0};

  ObjText& object(const std::string& name) { return line("o " + name); }
  ObjText& material(const std::string& name) { return line("usemtl " + name); }
  ObjText& line(const std::string& text) {
    body_ += text + "\n";
    return *this;
  }
  ObjText& face(const std::vector<Vec3>& corners) {
    std::string f = "f";
    for (const Vec3& x : corners) {
      const Vec3 y = x * scale + shift;
      char text[128];
      std::snprintf(text, sizeof text, "v %.17g %.17g %.17g\n", y.x, y.y, y.z);
      body_ += text;
      f += " " + std::to_string(++vertices_);
    }
    return line(f);
  }
  // A rectangle in the plane z, facing up, or down with `up` false.
  ObjText& floor(double x0, double y0, double x1, double y1, double z = 0, bool up = true) {
    if (up) return face({{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}});
    return face({{x0, y0, z}, {x0, y1, z}, {x1, y1, z}, {x1, y0, z}});
  }
  // A box facing outwards, or inwards.
  ObjText& box(const Vec3& lo, const Vec3& hi, bool outwards = true) {
    const auto corner = [&](int i) {
      return Vec3{i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z};
    };
    constexpr int kSides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                  {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& s : kSides) {
      std::vector<Vec3> f{corner(s[0]), corner(s[1]), corner(s[2]), corner(s[3])};
      if (!outwards) std::reverse(f.begin(), f.end());
      face(f);
    }
    return *this;
  }
  operator std::string() const { return body_; }

 private:
  std::string body_;
  int vertices_ = 0;
};

}  // namespace atrium
