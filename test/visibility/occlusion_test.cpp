#include "visibility/occlusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <thread>
#include <vector>

namespace atrium {
namespace {

struct Soup {
  std::vector<Polygon> polygons;
  std::vector<BlockerPolygon> blockers() const {
    std::vector<BlockerPolygon> out;
    for (std::size_t i = 0; i < polygons.size(); ++i)
      out.push_back({polygons[i], static_cast<std::uint32_t>(1000 + i)});
    return out;
  }
};

Polygon moved(Polygon polygon, double scale, const Vec3& offset) {
  for (Vec3& x : polygon) x = x * scale + offset;
  return polygon;
}

// The inside of a box, six quads facing inward.
Soup closed_room(const Vec3& s) {
  return {{{{0, 0, 0}, {s.x, 0, 0}, {s.x, s.y, 0}, {0, s.y, 0}},
           {{0, 0, s.z}, {0, s.y, s.z}, {s.x, s.y, s.z}, {s.x, 0, s.z}},
           {{0, 0, 0}, {0, 0, s.z}, {s.x, 0, s.z}, {s.x, 0, 0}},
           {{0, s.y, 0}, {s.x, s.y, 0}, {s.x, s.y, s.z}, {0, s.y, s.z}},
           {{0, 0, 0}, {0, s.y, 0}, {0, s.y, s.z}, {0, 0, s.z}},
           {{s.x, 0, 0}, {s.x, 0, s.z}, {s.x, s.y, s.z}, {s.x, s.y, 0}}}};
}

// Convex polygons of 3 to 7 corners on random circles in a cube of 10 m.
Soup random_soup(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> gauss;
  Soup soup;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 center = 10.0 * Vec3{unit(random), unit(random), unit(random)};
    const Vec3 n = normalize(Vec3{gauss(random), gauss(random), gauss(random)});
    const Vec3 u = normalize(cross(n, std::abs(n.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    const double radius = 0.2 + unit(random);
    const int corners = 3 + int(5 * unit(random));
    Polygon polygon;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * M_PI * (k + 0.5 * unit(random)) / corners;
      polygon.push_back(center + radius * (std::cos(angle) * u + std::sin(angle) * cross(n, u)));
    }
    soup.polygons.push_back(polygon);
  }
  return soup;
}

// Where from + t * along meets the polygon, and how far from its rim, in metres.
struct Crossing {
  double t, inside;
};
std::optional<Crossing> crossing(const Polygon& polygon, const Vec3& from, const Vec3& along) {
  const Plane plane = plane_of(polygon);
  const double slope = dot(plane.normal, along);
  if (slope == 0) return std::nullopt;
  const double t = -plane.distance(from) / slope;
  const Vec3 x = from + t * along;
  double inside = 1e300;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 edge = polygon[(i + 1) % polygon.size()] - polygon[i];
    inside = std::min(inside, dot(cross(plane.normal, normalize(edge)), x - polygon[i]));
  }
  return Crossing{t, inside};
}

class AgreesWithBruteForce : public testing::TestWithParam<std::pair<double, double>> {
};  // scale, offset

TEST_P(AgreesWithBruteForce, SegmentsAndRays) {
  const auto [scale, offset] = GetParam();
  const Vec3 move = offset * Vec3{1, -1, 0.5};
  Soup soup = random_soup(150, 7);
  for (Polygon& p : soup.polygons) p = moved(p, scale, move);
  const auto blockers = soup.blockers();
  const RayScene scene(blockers);

  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 10);
  // Float places an edge to about 1e-6 of the extent: closer calls are nobody's to decide.
  const double doubtful = 2e-5 * scale;
  int decided = 0, blocked = 0, hits = 0;
  for (int packet = 0; packet < 500; ++packet) {
    SegmentPacket segments;
    RayPacket rays;
    rays.coherent = packet % 2 == 0;  // a hint that changes no answer, false as it is here
    std::vector<std::pair<Vec3, Vec3>> ends;
    for (int i = 0; i < kRayLanes; ++i) {
      const Vec3 a = scale * Vec3{unit(random), unit(random), unit(random)} + move;
      const Vec3 b = scale * Vec3{unit(random), unit(random), unit(random)} + move;
      ends.push_back({a, b});
      if (i == 5) continue;  // a lane that is not in use
      segments.set(i, a, b);
      rays.set(i, a, b - a, 0);
    }
    std::uint16_t mask;
    scene.occluded16(segments, mask);
    HitPacket found;
    scene.closest_hit16(rays, found);
    EXPECT_FALSE((mask | found.found) >> 5 & 1);
    for (int i = 0; i < kRayLanes; ++i) {
      if (i == 5) continue;
      const auto [a, b] = ends[i];
      bool expected = false, doubt = false;
      double nearest = 1e300;
      std::uint32_t id = 0;
      for (const BlockerPolygon& blocker : blockers) {
        const auto c = crossing(Polygon(blocker.polygon.begin(), blocker.polygon.end()), a, b - a);
        if (!c || c->t < -1e-3 || c->inside < -doubtful) continue;
        doubt |= c->inside < doubtful || std::abs(c->t) < 1e-3 || std::abs(c->t - 1) < 1e-3;
        expected |= c->t > 0 && c->t < 1;
        if (c->t < nearest) {
          nearest = c->t;
          id = blocker.id;
        }
      }
      if (doubt) continue;
      ++decided;
      blocked += expected;
      EXPECT_EQ(mask >> i & 1, expected);
      EXPECT_EQ(scene.occluded(a, b), expected);
      EXPECT_EQ(found.found >> i & 1, nearest < 1e300);
      const auto hit = scene.closest_hit(a, b - a, 0);
      ASSERT_EQ(hit.has_value(), nearest < 1e300);
      if (!hit) continue;
      ++hits;
      const double l = length(b - a);
      EXPECT_EQ(hit->id, id);
      EXPECT_EQ(found.hit[i].id, id);
      EXPECT_NEAR(hit->t / l, nearest, 1e-9);
      EXPECT_EQ(found.hit[i].t, hit->t);
      EXPECT_LE(length(hit->point - (a + nearest * (b - a))), 1e-8 * scale);
    }
  }
  // The situation is a real one: most calls are clear, both answers are common.
  EXPECT_GT(decided, 7000);
  EXPECT_GT(blocked, 2000);
  EXPECT_LT(blocked, 6000);
  EXPECT_GT(hits, blocked);
}

INSTANTIATE_TEST_SUITE_P(RayScene, AgreesWithBruteForce,
                         testing::Values(std::pair{1.0, 0.0}, std::pair{1e-6, 0.0},
                                         std::pair{1.0, 1e6}, std::pair{1e3, 0.0}));

TEST(RayScene, EmptySceneBlocksNothing) {
  const RayScene scene({});
  EXPECT_FALSE(scene.occluded({0, 0, 0}, {1, 2, 3}));
  EXPECT_FALSE(scene.closest_hit({0, 0, 0}, {1, 2, 3}, 0));
}

// Any two points of a convex room's walls see each other, also along the walls' own edges.
TEST(RayScene, ConvexEmptyRoomBlocksNothing) {
  const Soup room = closed_room({4, 3, 2.5});
  const auto blockers = room.blockers();
  // Turned, so that float cannot place the walls exactly.
  std::vector<Polygon> turned;
  const Vec3 u = normalize(Vec3{1, 2, 3}), v = normalize(cross(u, Vec3{0, 0, 1})), w = cross(u, v);
  for (const BlockerPolygon& b : blockers) {
    Polygon p;
    for (const Vec3& x : b.polygon) p.push_back(x.x * u + x.y * v + x.z * w);
    turned.push_back(p);
  }
  const Soup turned_room{turned};
  const auto walls = turned_room.blockers();
  const RayScene scene(walls);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  std::uniform_real_distribution<double> exponent(-5, 0);
  int wrong = 0;
  for (int i = 0; i < 100000; ++i) {
    const auto point = [&](const Polygon& p) {
      // Down to 1e-5 of the width from an edge: the flattest of segments too.
      const double s = std::pow(10, exponent(random)), t = unit(random);
      return (1 - s) * ((1 - t) * p[0] + t * p[1]) + s * ((1 - t) * p[3] + t * p[2]);
    };
    const Polygon &p = turned[random() % 6], &q = turned[random() % 6];
    wrong += scene.occluded(point(p), point(q));
  }
  EXPECT_EQ(wrong, 0);
}

// No ray leaves a closed room, through the quads' diagonals and shared edges neither.
TEST(RayScene, ClosedRoomLetsNothingOut) {
  const Soup room = closed_room({4, 3, 2.5});
  const auto blockers = room.blockers();
  const RayScene scene(blockers);
  std::mt19937 random(5);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 x = Vec3{4 * unit(random), 3 * unit(random), 2.5 * unit(random)};
    Vec3 d{gauss(random), gauss(random), gauss(random)};
    // At corners and edges on purpose, every third time.
    if (i % 3 == 0) d = Vec3{4.0 * (random() % 2), 3.0 * (random() % 2), 2.5 * unit(random)} - x;
    EXPECT_TRUE(scene.closest_hit(x, d, 0)) << i;
  }
}

TEST(RayScene, HitOnTheFrontAndOnTheBack) {
  const Polygon plate{{0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}};  // front up
  const BlockerPolygon blocker{plate, 42};
  const RayScene scene({&blocker, 1});
  for (const double side : {1.0, -1.0}) {
    const auto hit = scene.closest_hit({0.5, 0.25, 1 + 3 * side}, {0, 0, -2 * side}, 0);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->id, 42u);
    EXPECT_DOUBLE_EQ(hit->t, 3);  // metres, whatever the direction's length
    EXPECT_DOUBLE_EQ(hit->normal.z, 1);
    EXPECT_DOUBLE_EQ(hit->point.z, 1);
  }
  EXPECT_FALSE(scene.closest_hit({0.5, 0.25, 4}, {0, 0, -1}, 3.001));
  EXPECT_TRUE(scene.closest_hit({0.5, 0.25, 4}, {0, 0, -1}, 2.999));
}

TEST(RayScene, CountsItsMemory) {
  const auto small = random_soup(10, 1), large = random_soup(5000, 1);
  const auto few = small.blockers(), many = large.blockers();
  const RayScene a(few), b(many), c(many);
  EXPECT_GT(b.bytes(), a.bytes());
  EXPECT_EQ(b.bytes(), c.bytes());
  // Three triangles a polygon of 5 corners: at the least their corners and indices.
  EXPECT_GT(b.bytes(), 5000u * (5 * 12 + 3 * 12));
  EXPECT_LT(b.bytes(), 5000u * 3 * 400);
}

TEST(RayScene, ManyThreadsGetTheAnswersOfOne) {
  const Soup soup = random_soup(300, 9);
  const auto blockers = soup.blockers();
  const RayScene scene(blockers);
  const auto ask = [&] {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 10);
    std::vector<std::uint16_t> masks;
    for (int packet = 0; packet < 300; ++packet) {
      SegmentPacket segments;
      for (int i = 0; i < kRayLanes; ++i)
        segments.set(i, {unit(random), unit(random), unit(random)},
                     {unit(random), unit(random), unit(random)});
      std::uint16_t mask;
      scene.occluded16(segments, mask);
      masks.push_back(mask);
    }
    return masks;
  };
  const auto alone = ask();
  std::vector<std::vector<std::uint16_t>> answers(4);
  std::vector<std::thread> threads;
  for (auto& answer : answers) threads.emplace_back([&] { answer = ask(); });
  for (std::thread& t : threads) t.join();
  for (const auto& answer : answers) EXPECT_EQ(answer, alone);
}

}  // namespace
}  // namespace atrium
