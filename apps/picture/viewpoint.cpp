#include "apps/picture/viewpoint.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace atrium {
namespace {

// The coordinate axis that v comes nearest to, with its sign.
Vec3 snapped(const Vec3& v) {
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(v[k]) > std::abs(v[axis])) axis = k;
  Vec3 unit(0);
  unit[axis] = v[axis] < 0 ? -1 : 1;
  return unit;
}

// A box as seen by someone who stands in it.
struct Room {
  Vec3 center{0}, up{0}, across{0}, along{0};                     // unit axes
  double half_across = 0, half_along = 0, floor = 0, height = 0;  // m; floor along up

  Room(const Box& box, const Vec3& up_axis) : center(box.center()), up(up_axis) {
    across = std::abs(up.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    along = cross(up, across);
    const auto half = [&](const Vec3& axis) { return 0.5 * std::abs(dot(box.extent(), axis)); };
    half_across = half(across);
    half_along = half(along);
    height = 2 * half(up);
    floor = dot(center, up) - 0.5 * height;
  }
  // a, b: -1 to 1 across and along; h: m above the floor.
  Vec3 at(double a, double b, double h) const {
    return center + a * half_across * across + b * half_along * along +
           (floor + h - dot(center, up)) * up;
  }
};

constexpr double kEyeHeight = 1.6;  // m
constexpr double kEyeShare = 0.6;   // of the height of a low room
constexpr double kHallHeight = 30;  // m; above it the scene is taken not to be in metres
constexpr double kHallEyeShare = 0.45;
constexpr double kTargetShare = 0.42;  // of the room's height
constexpr double kInset = 0.86;        // of the way from the middle to a wall
constexpr std::size_t kMostRooms = 12;
constexpr std::size_t kFewPatches = 100;  // of a scene that is a box with little in it
constexpr double kLongScene = 2.5;        // extents' ratio; longer is no such box
constexpr int kProbeWidth = 40, kProbeHeight = 30;

double eye_height(double room_height) {
  if (room_height > kHallHeight) return kHallEyeShare * room_height;
  return std::min(kEyeHeight, kEyeShare * room_height);
}

struct Candidate {
  Camera camera;
  bool outside = false;
  double variety = 0;     // bits: how many things share the picture, and how evenly
  double reach = 0;       // log2 of the mean square of how far it sees, halved
  double brightness = 0;  // mean log2 of luminance
  bool blocked = false;   // stands inside something
};

std::vector<Candidate> inside(const Room& room, const Vec3& up, double fov) {
  std::vector<Candidate> views;
  const double eye = eye_height(room.height);
  for (const auto& [a, b] : {std::pair{-1., -1.},
                             {1., -1.},
                             {-1., 1.},
                             {1., 1.},
                             {-1., 0.},
                             {1., 0.},
                             {0., -1.},
                             {0., 1.}})
    views.push_back({look_at(room.at(kInset * a, kInset * b, eye),
                             room.at(-a, -b, kTargetShare * room.height), up, fov)});
  return views;
}

// Into the scene's box from before each of its four upright sides, which then fill the picture.
std::vector<Candidate> outside(const Room& room, const Vec3& up, double fov, double aspect) {
  constexpr double kMargin = 1.03;
  std::vector<Candidate> views;
  for (const auto& [a, b] : {std::pair{0., -1.}, {0., 1.}, {-1., 0.}, {1., 0.}}) {
    const double depth = a != 0 ? room.half_across : room.half_along;
    const double width = a != 0 ? room.half_along : room.half_across;
    const Vec3 middle = room.at(0, 0, 0.5 * room.height);
    Camera camera = look_at(middle + a * room.across + b * room.along, middle, up, fov);
    const double away = std::max(0.5 * room.height, width / aspect) * kMargin / camera.half_height;
    camera.eye = middle - (depth + away) * camera.forward;
    views.push_back({camera, true});
  }
  return views;
}

Status judge(LitScene& scene, Candidate& view, double aspect) {
  constexpr double kNear = 0.08;      // of the scene's extent: too near to be a view
  constexpr double kMostNear = 0.15;  // of the rays
  Camera& camera = view.camera;
  camera.height = kProbeHeight;
  camera.width = static_cast<int>(std::lround(kProbeHeight * aspect));
  std::map<std::uint32_t, int> seen;
  int hits = 0, through = 0, near = 0;
  double logs = 0, squares = 0;
  const double scale = std::min(scene.run().bounds.diagonal(), 10.0);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Vec3 d = camera.direction(x + 0.5, y + 0.5);
      const auto hit = scene.first_lit(camera.eye, d, 0);
      if (!hit) continue;
      ++hits, ++seen[hit->patch.value];
      through += hit->passed > 0;
      near += hit->t < kNear * scale;
      squares += hit->t * hit->t * dot(d, d);
      const auto shaded = scene.shaded(hit->patch);
      if (!shaded.ok()) return shaded.status();
      const ShadedPatch& patch = **shaded;
      const Vec2 p = patch.frame.to_plane(hit->x);
      constexpr double kBlack = 1e-6;
      logs += std::log2(luminance(radiosity_at(patch, patch.faces[face_at(patch, p)], p)) + kBlack);
    }
  const double rays = camera.width * camera.height;
  view.blocked = hits == 0 || (!view.outside && (through > 0 || near > kMostNear * rays));
  if (view.blocked) return {};
  for (const auto& [patch, count] : seen) {
    const double share = count / static_cast<double>(hits);
    view.variety -= share * std::log2(share);
  }
  view.variety *= hits / rays;
  view.reach = 0.5 * std::log2(squares / hits);
  view.brightness = logs / hits;
  return {};
}

// Boxes around the lit rooms, the largest first.
std::vector<Box> lit_rooms(const Model& model) {
  std::map<std::uint32_t, Box> rooms;
  for (const Cell& cell : model.cells)
    if (cell.lit) rooms[cell.room].extend(cell.bounds);
  std::vector<Box> boxes;
  for (const auto& [room, box] : rooms) boxes.push_back(box);
  const auto volume = [](const Box& b) { return b.extent().x * b.extent().y * b.extent().z; };
  std::stable_sort(boxes.begin(), boxes.end(),
                   [&](const Box& a, const Box& b) { return volume(a) > volume(b); });
  return boxes;
}

std::vector<Candidate> candidates(const RunModel& run, const Vec3& up, double fov, double aspect) {
  std::vector<Box> rooms = lit_rooms(run.model);
  const Room all(run.bounds, up);
  const double longer = std::max(all.half_across, all.half_along);
  if (run.model.patches.size() <= kFewPatches &&
      longer <= kLongScene * std::min(all.half_across, all.half_along))
    return outside(all, up, fov, aspect);
  if (rooms.size() > kMostRooms) rooms.resize(kMostRooms);
  std::vector<Candidate> views;
  for (const Box& box : rooms)
    for (const Candidate& c : inside(Room(box, up), up, fov)) views.push_back(c);
  return views;
}

// Areas of level surfaces by height, in steps of the scene's.
class Levels {
 public:
  Levels(const Model& model, const Box& box, const Vec3& up, double sign) : up_(up) {
    constexpr double kLevel = 0.99;  // cosine
    constexpr int kSteps = 400;
    step_ = std::abs(dot(box.extent(), up)) / kSteps;
    if (!(step_ > 0)) return;
    for (const Patch& patch : model.patches) {
      const PolygonView polygon = model.polygon(patch);
      const Vec3 a = area_vector(polygon);
      if (sign * dot(a, up) < kLevel * length(a)) continue;
      area_[static_cast<int>(std::floor(dot(polygon[0], up) / step_))] += 0.5 * length(a);
    }
  }
  // The highest below `height` with at least `share` of the largest level's area.
  std::optional<double> highest(double height, double share) const {
    double largest = 0;
    for (const auto& [level, area] : area_) largest = std::max(largest, area);
    for (auto at = area_.rbegin(); at != area_.rend(); ++at)
      if ((at->first + 1) * step_ <= height && at->second >= share * largest)
        return (at->first + 0.5) * step_;
    return std::nullopt;
  }
  double step() const { return step_; }

 private:
  Vec3 up_;
  double step_ = 0;
  std::map<int, double> area_;  // m², by level
};

// Under the ceiling of the topmost storey, above what stands on its floor.
double storey_cut(const RunModel& run, const Vec3& up) {
  constexpr double kCeilingShare = 0.2, kFloorShare = 0.3;  // of the largest level's area
  constexpr double kCut = 0.8;                              // of the storey's height
  const Levels down(run.model, run.bounds, up, -1), upward(run.model, run.bounds, up, 1);
  const double top = std::max(dot(run.bounds.lo, up), dot(run.bounds.hi, up));
  const double bottom = std::min(dot(run.bounds.lo, up), dot(run.bounds.hi, up));
  const double ceiling = down.highest(top + 2 * down.step(), kCeilingShare).value_or(top);
  const double floor = upward.highest(ceiling - down.step(), kFloorShare).value_or(bottom);
  return floor + kCut * (ceiling - floor);
}

}  // namespace

Result<Vec3> up_direction(Solution& solution) {
  constexpr double kOneWay = 0.3;  // of all flux: less goes all ways
  Vec3 flow(0);
  double flux = 0;
  const Status read = solution.for_each_cluster([&](ClusterId, const ClusterView& cluster) {
    for (std::size_t p = 0; p < cluster.size(); ++p) {
      const PatchHead& head = cluster.patch_head(p);
      if (solution.run().model.patches[head.patch].back != 0) continue;
      const double lumens = head.area * luminance(head.exitance);
      flux += lumens;
      flow += lumens * head.frame.n;
    }
  });
  if (!read.ok()) return read;
  const Vec3 down = snapped(flow);
  if (std::abs(dot(flow, down)) <= kOneWay * flux) return Vec3(0, 0, 1);
  return -down;
}

Result<Camera> interior_view(LitScene& scene, const Vec3& up, double fov, double aspect) {
  constexpr double kBitsPerStop = 0.5;  // a stop darker weighs as much as this much less variety
  constexpr double kMostStops = 6;
  std::vector<Candidate> views = candidates(scene.run(), snapped(up), fov, aspect);
  double brightest = -std::numeric_limits<double>::infinity();
  for (Candidate& view : views) {
    ATRIUM_RETURN_IF_ERROR(judge(scene, view, aspect));
    if (!view.blocked) brightest = std::max(brightest, view.brightness);
  }
  const auto worth = [&](const Candidate& v) {
    if (v.blocked) return -std::numeric_limits<double>::infinity();
    return v.variety + v.reach - kBitsPerStop * std::min(brightest - v.brightness, kMostStops);
  };
  const auto best =
      std::max_element(views.begin(), views.end(),
                       [&](const Candidate& a, const Candidate& b) { return worth(a) < worth(b); });
  if (best == views.end() || best->blocked) {
    const Room all(scene.run().bounds, snapped(up));
    return outside(all, up, fov, aspect).front().camera;
  }
  return best->camera;
}

Overhead overhead_view(const RunModel& run, const Vec3& up, double fov,
                       std::optional<double> cut_height, std::optional<double> aspect) {
  constexpr double kMargin = 1.04;
  const Vec3 axis = snapped(up);
  const Room all(run.bounds, axis);
  const double cut = cut_height ? *cut_height : storey_cut(run, axis);
  // The longer side runs along the picture's width.
  const bool turned = all.half_along > all.half_across;
  const double width = turned ? all.half_along : all.half_across;
  const double height = turned ? all.half_across : all.half_along;
  const Vec3 picture_up = turned ? -all.across : all.along;
  Overhead view{{}, {axis, cut}, aspect ? *aspect : width / height};
  const Vec3 middle = all.center + (cut - dot(all.center, axis)) * axis;
  view.camera = look_at(middle + axis, middle, picture_up, fov);
  const double half = std::max(height, width / view.aspect) * kMargin;
  view.camera.eye = middle + half / view.camera.half_height * axis;
  return view;
}

}  // namespace atrium
