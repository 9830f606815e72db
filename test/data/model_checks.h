// What must hold for every generated model, whatever its kind; each check reports the first few
// offenders by group.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "data/dice.h"
#include "data/generate.h"
#include "test/data/ray_grid.h"

namespace atrium {

inline GeneratedModel generated(const GenerateOptions& options) {
  Result<GeneratedModel> model = generate(options);
  if (!model.ok()) ADD_FAILURE() << options.kind << ": " << model.status().message();
  return model.ok() ? std::move(*model) : GeneratedModel{};
}

inline const std::string& group_of(const GeneratedModel& m, std::size_t face) {
  const auto after = std::ranges::upper_bound(
      m.groups, face, {}, [](const GeneratedGroup& g) { return std::size_t{g.first_face}; });
  return (after - 1)->name;
}

// Planar and convex to rounding, of area, named once, no group empty.
inline void expect_sound_faces(const GeneratedModel& m) {
  constexpr double kRounding = 1e-12;  // m; coordinates of up to 100 m have 1e-14
  for (std::size_t f = 0; f < m.faces.size(); ++f) {
    const PolygonView p = m.polygon(m.faces[f]);
    ASSERT_GT(area(p), 1e-8) << group_of(m, f);
    ASSERT_LT(planarity(p), kRounding) << group_of(m, f);
    ASSERT_TRUE(is_convex(p, kRounding)) << group_of(m, f);
  }
  std::set<std::string> names;
  for (const GeneratedGroup& g : m.groups) {
    ASSERT_GT(g.face_count, 0u) << g.name;
    ASSERT_TRUE(names.insert(g.name).second) << g.name << " twice";
  }
}

// No two faces of a group that lie in one plane, look the same way, have one paint and share a part
// of an edge make up a convex polygon together.
inline void expect_nothing_rejoinable(const GeneratedModel& m) {
  constexpr double kNear = 1e-7;  // m, and of a unit normal
  for (const GeneratedGroup& g : m.groups) {
    // Sorted by plane, faces that could be joined are neighbours in a bucket.
    std::map<std::array<long, 5>, std::vector<std::size_t>> planes;
    for (std::size_t f = g.first_face; f < g.first_face + g.face_count; ++f) {
      const Plane p = plane_of(m.polygon(m.faces[f]));
      const auto key = [](double x) { return std::lround(x * 1e5); };
      planes[{static_cast<long>(m.faces[f].paint), key(p.normal.x), key(p.normal.y),
              key(p.normal.z), key(p.offset)}]
          .push_back(f);
    }
    for (const auto& [key, faces] : planes) {
      for (std::size_t i = 0; i < faces.size(); ++i) {
        for (std::size_t j = i + 1; j < faces.size(); ++j) {
          const PolygonView p = m.polygon(m.faces[faces[i]]), q = m.polygon(m.faces[faces[j]]);
          // The union is convex exactly if the two fill their common convex hull.
          const Vec3 n = normalize(area_vector(p));
          const Frame frame = frame_of(p);
          std::vector<Vec2> points;
          for (const Vec3& v : p) points.push_back(frame.to_plane(v));
          for (const Vec3& v : q) points.push_back(frame.to_plane(v));
          std::ranges::sort(points, [](const Vec2& a, const Vec2& b) {
            return a.x != b.x ? a.x < b.x : a.y < b.y;
          });
          std::vector<Vec2> hull;
          for (int pass = 0; pass < 2; ++pass) {
            const std::size_t start = hull.size();
            for (const Vec2& x : points) {
              while (hull.size() >= start + 2) {
                const Vec2 a = hull[hull.size() - 2], b = hull.back();
                if ((b.x - a.x) * (x.y - a.y) - (b.y - a.y) * (x.x - a.x) > 0) break;
                hull.pop_back();
              }
              hull.push_back(x);
            }
            hull.pop_back();
            std::ranges::reverse(points);
          }
          double twice = 0;
          for (std::size_t k = 0, l = hull.size() - 1; k < hull.size(); l = k++)
            twice += hull[l].x * hull[k].y - hull[l].y * hull[k].x;
          const double gap = twice / 2 - area(p) - area(q);
          ASSERT_GT(gap, kNear * std::sqrt(std::max(area(p), area(q))))
              << g.name << ": two faces with the normal " << n.x << " " << n.y << " " << n.z
              << (gap < -kNear ? " overlap" : " could be one");
        }
      }
    }
  }
}

// Σ of the faces' area vectors: nothing for the closed boundary of the air; a solid that lacks the
// face it stands on adds that face's area, upwards.
inline Vec3 net_area(const GeneratedModel& m) {
  Vec3 sum(0);
  for (const GeneratedFace& f : m.faces) sum += area_vector(m.polygon(f)) / 2.0;
  return sum;
}

// From points uniform by area on the fronts, rays uniform in angle: none escapes. Where solids
// touch, a part of a front lies under them, and all its rays hit the solid from inside (backs);
// from anywhere else only fronts are seen, so a point never sees both.
inline void expect_closed(const GeneratedModel& m, int points, double covered_allowed) {
  constexpr int kRaysEach = 4;
  constexpr double kLift = 1e-7;  // m
  const RayGrid grid(m);
  std::vector<double> cumulative;
  double total = 0;
  for (const GeneratedFace& f : m.faces) cumulative.push_back(total += area(m.polygon(f)));
  Dice dice(20, "expect_closed");
  int covered = 0;
  for (int i = 0; i < points; ++i) {
    const auto f = static_cast<std::size_t>(
        std::ranges::upper_bound(cumulative, dice.uniform(0, total)) - cumulative.begin());
    const PolygonView p = m.polygon(m.faces[f]);
    // Uniform in the fan's triangles.
    double pick = dice.uniform(0, area(p));
    Vec3 from = p[0];
    for (std::size_t k = 1; k + 1 < p.size(); ++k) {
      const double part = length(cross(p[k] - p[0], p[k + 1] - p[0])) / 2;
      pick -= part;
      if (pick > 0 && k + 2 < p.size()) continue;
      const double a = std::sqrt(dice.uniform(0, 1)), b = dice.uniform(0, 1);
      from = p[0] + a * ((1 - b) * (p[k] - p[0]) + b * (p[k + 1] - p[0]));
      break;
    }
    const Frame frame = frame_of(p);
    from += kLift * frame.n;
    int fronts = 0, backs = 0;
    for (int r = 0; r < kRaysEach; ++r) {
      const double z = dice.uniform(1e-3, 1), t = dice.uniform(0, 2 * std::numbers::pi);
      const double s = std::sqrt(1 - z * z);
      const Vec3 d = s * std::cos(t) * frame.u + s * std::sin(t) * frame.v + z * frame.n;
      const auto hit = grid.first_hit(from, d, f);
      ASSERT_TRUE(hit) << "a ray escapes from " << group_of(m, f) << " at " << from.x << " "
                       << from.y << " " << from.z;
      ++(hit->front ? fronts : backs);
      ASSERT_TRUE(fronts == 0 || backs == 0)
          << group_of(m, f) << " at " << from.x << " " << from.y << " " << from.z
          << " sees fronts and backs, one of " << group_of(m, hit->face);
    }
    covered += backs > 0;
  }
  EXPECT_LE(covered, covered_allowed * points);
}

// Structure, then lamps, then furniture.
inline void expect_modellers_order(const GeneratedModel& m) {
  int stage = 0;
  for (const GeneratedGroup& g : m.groups) {
    const int now = g.name.find("/furniture") != std::string::npos ? 2
                    : g.name.find("/lamp") != std::string::npos    ? 1
                                                                   : 0;
    ASSERT_GE(now, stage) << g.name;
    stage = now;
  }
}

}  // namespace atrium
