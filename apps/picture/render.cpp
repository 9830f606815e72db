#include "apps/picture/render.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>

namespace atrium {
namespace {

constexpr int kTile = 32;               // samples a side
constexpr double kLineHalfWidth = 0.6;  // pixels, of an element's edge

double distance_to_edge(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double length2 = dot(d, d);
  const double t = length2 > 0 ? std::clamp(dot(p - a, d) / length2, 0.0, 1.0) : 0;
  return length(p - a - t * d);
}

class Renderer {
 public:
  Renderer(LitScene& scene, const RenderOptions& options)
      : scene_(scene), options_(options), camera_(options.camera) {
    rendering_.luminance = Image(camera_.width * options.side, camera_.height * options.side);
    rendering_.what.resize(rendering_.luminance.pixels.size());
  }

  Result<Rendering> run() {
    const int hardware = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    const int count = options_.threads > 0 ? options_.threads : hardware;
    std::vector<std::thread> workers;
    for (int i = 0; i < count; ++i) workers.emplace_back([this] { work(); });
    for (std::thread& w : workers) w.join();
    if (!failure_.ok()) return failure_;
    return std::move(rendering_);
  }

 private:
  void work() {
    const Image& image = rendering_.luminance;
    const int across = (image.width + kTile - 1) / kTile, down = (image.height + kTile - 1) / kTile;
    for (int tile = next_tile_++; tile < across * down && !failed_; tile = next_tile_++) {
      const Status status = draw_tile(tile % across * kTile, tile / across * kTile);
      if (status.ok()) continue;
      const std::lock_guard lock(mutex_);
      if (!failed_.exchange(true)) failure_ = status;
    }
  }

  Status draw_tile(int left, int top) {
    const Image& image = rendering_.luminance;
    for (int y = top; y < std::min(top + kTile, image.height); ++y)
      for (int x = left; x < std::min(left + kTile, image.width); ++x)
        ATRIUM_RETURN_IF_ERROR(draw_sample(x, y));
    return {};
  }

  // Where the ray comes below the cut.
  double start(const Vec3& direction) const {
    if (!options_.cut) return 0;
    const double above = options_.cut->distance(camera_.eye);
    const double sinking = -dot(options_.cut->normal, direction);
    return above > 0 && sinking > 0 ? above / sinking : 0;
  }

  Status draw_sample(int sx, int sy) {
    const Vec2 pixel{(sx + 0.5) / options_.side, (sy + 0.5) / options_.side};
    const Vec3 direction = camera_.direction(pixel.x, pixel.y);
    const std::optional<LitPoint> hit = scene_.first_lit(camera_.eye, direction, start(direction));
    if (!hit) return {};
    const Result<const ShadedPatch*> shaded = scene_.shaded(hit->patch);
    if (!shaded.ok()) return shaded.status();
    const ShadedPatch& patch = **shaded;
    const Vec2 p = patch.frame.to_plane(hit->x);
    const ShadedFace& face = patch.faces[face_at(patch, p)];
    const Spectrum l = radiosity_at(patch, face, p) / std::numbers::pi;
    const Image& image = rendering_.luminance;
    const std::size_t at = static_cast<std::size_t>(sy) * static_cast<std::size_t>(image.width) +
                           static_cast<std::size_t>(sx);
    rendering_.luminance.pixels[at] = {static_cast<float>(l.x), static_cast<float>(l.y),
                                       static_cast<float>(l.z)};
    rendering_.what[at] = patch.emits ? kLamp : kSurface;
    if (options_.mesh && on_edge(patch, face, pixel)) rendering_.what[at] = kEdge;
    return {};
  }

  // Is the sample within a line's width of the face's outline, as the picture shows it?
  bool on_edge(const ShadedPatch& patch, const ShadedFace& face, const Vec2& pixel) const {
    const std::span<const std::uint32_t> outline = patch.outline_of(face);
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vec3 a = patch.frame.to_space(patch.corners[outline[i]].p);
      const Vec3 b = patch.frame.to_space(patch.corners[outline[(i + 1) % outline.size()]].p);
      if (edge_near(a, b, pixel)) return true;
    }
    return false;
  }

  bool edge_near(Vec3 a, Vec3 b, const Vec2& pixel) const {
    // Only what is before the eye can be projected.
    const double near = 1e-3 * length(b - a);
    double da = camera_.depth(a), db = camera_.depth(b);
    if (da < near && db < near) return false;
    if (da < near) a += (b - a) * ((near - da) / (db - da));
    if (db < near) b += (a - b) * ((near - db) / (da - db));
    return distance_to_edge(pixel, camera_.project(a), camera_.project(b)) < kLineHalfWidth;
  }

  LitScene& scene_;
  const RenderOptions& options_;
  const Camera& camera_;
  Rendering rendering_;
  std::atomic<int> next_tile_{0};
  std::atomic<bool> failed_{false};
  std::mutex mutex_;
  Status failure_;
};

}  // namespace

Result<Rendering> render(LitScene& scene, const RenderOptions& options) {
  return Renderer(scene, options).run();
}

}  // namespace atrium
