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
using namespace generator;

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

// No two faces of the model lie over one another in one plane, whichever way they look.
inline void expect_no_overlap(const GeneratedModel& m) {
  constexpr double kNear = 1e-6;     // m: planes nearer than this are one
  constexpr double kOverlap = 1e-7;  // m²
  struct Flat {
    long offset;
    Box box;
    std::size_t face;
  };
  std::map<std::array<long, 3>, std::vector<Flat>> by_normal;
  for (std::size_t f = 0; f < m.faces.size(); ++f) {
    Plane p = plane_of(m.polygon(m.faces[f]));
    const auto key = [](double x) { return std::lround(x * 1e6); };
    std::array<long, 3> n{key(p.normal.x), key(p.normal.y), key(p.normal.z)};
    if (n < std::array<long, 3>{0, 0, 0}) {
      p = p.flipped();
      for (long& x : n) x = -x;
    }
    by_normal[n].push_back({std::lround(p.offset / kNear), bounds(m.polygon(m.faces[f])), f});
  }
  for (auto& [normal, flats] : by_normal) {
    std::ranges::sort(flats, [](const Flat& a, const Flat& b) {
      return a.offset != b.offset ? a.offset < b.offset : a.box.lo.x < b.box.lo.x;
    });
    for (std::size_t i = 0; i < flats.size(); ++i) {
      for (std::size_t j = i + 1; j < flats.size() && flats[j].offset == flats[i].offset &&
                                  flats[j].box.lo.x <= flats[i].box.hi.x;
           ++j) {
        if (!flats[i].box.overlaps(flats[j].box, kNear)) continue;
        const PolygonView p = m.polygon(m.faces[flats[i].face]);
        const PolygonView q = m.polygon(m.faces[flats[j].face]);
        const Vec3 n = normalize(area_vector(p));
        Polygon common(q.begin(), q.end());
        for (std::size_t k = 0; k < p.size() && !common.empty(); ++k) {
          const Vec3 inwards = normalize(cross(n, p[(k + 1) % p.size()] - p[k]));
          common = clip(common, {inwards, dot(inwards, p[k])}, 1e-9);
        }
        ASSERT_TRUE(common.empty() || area(common) < kOverlap)
            << group_of(m, flats[i].face) << " and " << group_of(m, flats[j].face) << " overlap in "
            << area(common) << " m²";
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

// A point on a face's front, just above it.
struct FrontPoint {
  std::size_t face = 0;
  Frame frame;  // of the face, its origin the point
};

inline FrontPoint front_point(const GeneratedModel& m, std::size_t face, const Vec3& x) {
  constexpr double kLift = 1e-7;  // m
  FrontPoint p{face, frame_of(m.polygon(m.faces[face]))};
  p.frame.origin = x + kLift * p.frame.n;
  return p;
}

// Points uniform by area on the fronts of all faces.
class FrontPoints {
 public:
  explicit FrontPoints(const GeneratedModel& m) : model_(m) {
    for (std::size_t f = 0; f < m.faces.size(); ++f) {
      const PolygonView p = m.polygon(m.faces[f]);
      for (std::size_t k = 1; k + 1 < p.size(); ++k) {
        triangles_.push_back({f, k});
        total_ += length(cross(p[k] - p[0], p[k + 1] - p[0])) / 2;
        cumulative_.push_back(total_);
      }
    }
  }
  FrontPoint draw(Dice& dice) const {
    const auto i = static_cast<std::size_t>(
        std::ranges::upper_bound(cumulative_, dice.uniform(0, total_)) - cumulative_.begin());
    return in_triangle(std::min(i, triangles_.size() - 1), dice);
  }
  std::size_t triangles() const { return triangles_.size(); }
  FrontPoint in_triangle(std::size_t i, Dice& dice) const {
    const auto [face, k] = triangles_[i];
    const PolygonView p = model_.polygon(model_.faces[face]);
    const double a = std::sqrt(dice.uniform(0, 1)), b = dice.uniform(0, 1);
    return front_point(model_, face, p[0] + a * ((1 - b) * (p[k] - p[0]) + b * (p[k + 1] - p[0])));
  }

 private:
  const GeneratedModel& model_;
  std::vector<std::pair<std::size_t, std::size_t>> triangles_;
  std::vector<double> cumulative_;
  double total_ = 0;
};

// A ray uniform in solid angle over the point's front.
inline std::optional<RayHit> look(const RayGrid& grid, const FrontPoint& p, Dice& dice,
                                  Vec3* where) {
  const double z = dice.uniform(1e-3, 1), t = dice.uniform(0, 2 * std::numbers::pi);
  const double s = std::sqrt(1 - z * z);
  const Vec3 d = s * std::cos(t) * p.frame.u + s * std::sin(t) * p.frame.v + z * p.frame.n;
  const auto hit = grid.first_hit(p.frame.origin, d, p.face);
  if (hit) *where = p.frame.origin + hit->distance * d;
  return hit;
}

// No ray from a front escapes, from points in every face and from more uniform by area. What lies
// under something that stands on it looks at the inside of that thing: at backs, and at fronts that
// are covered too. Anything else sees fronts only.
inline void expect_closed(const GeneratedModel& m, int points, double covered_allowed) {
  constexpr int kRaysEach = 4, kRaysToSeeBack = 16;
  const RayGrid grid(m);
  const FrontPoints fronts(m);
  Dice dice(20, "expect_closed");
  const auto place = [&](const FrontPoint& p) {
    const Vec3& x = p.frame.origin;
    return group_of(m, p.face) + " at " + std::to_string(x.x) + " " + std::to_string(x.y) + " " +
           std::to_string(x.z);
  };
  int covered = 0;
  const int every = static_cast<int>(fronts.triangles());
  for (int i = -every; i < points; ++i) {
    const FrontPoint p =
        i < 0 ? fronts.in_triangle(static_cast<std::size_t>(-i - 1), dice) : fronts.draw(dice);
    std::string back;
    std::vector<FrontPoint> seen;
    for (int r = 0; r < kRaysEach; ++r) {
      Vec3 where;
      const auto hit = look(grid, p, dice, &where);
      ASSERT_TRUE(hit) << "a ray escapes from " << place(p);
      if (hit->front) {
        seen.push_back(front_point(m, hit->face, where));
      } else {
        back = group_of(m, hit->face);
      }
    }
    if (back.empty()) continue;
    covered += i >= 0;
    for (const FrontPoint& q : seen) {
      bool inside = false;
      for (int r = 0; r < kRaysToSeeBack && !inside; ++r) {
        Vec3 where;
        const auto hit = look(grid, q, dice, &where);
        ASSERT_TRUE(hit) << "a ray escapes from " << place(q);
        inside = !hit->front;
      }
      ASSERT_TRUE(inside) << place(p) << " sees the back of " << back << " and the air at "
                          << place(q);
    }
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
