#include "apps/picture/floor_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <map>
#include <optional>
#include <sstream>

#include "apps/picture/svg.h"

namespace atrium {
namespace {

constexpr double kOneWay = 0.3;                  // of all flux: less goes all ways
constexpr double kLevel = 0.99;                  // cosine: a surface this level is a floor
constexpr double kStoreyShare = 0.3;             // of the largest level's area: less is no storey
constexpr double kStoreyHeight = 2;              // m: levels nearer to each other are one storey
constexpr double kSameLevel = 0.01;              // m
constexpr double kWidth = 1400, kHeight = 1100;  // px, of the plan at most
constexpr double kLeastWidth = 900;              // px, of the picture: title and legend
constexpr double kMargin = 30, kHead = 60, kFoot = 70;    // px
constexpr double kLabelArea = 1;                          // m²: smaller rooms have no number
constexpr double kLargestLabel = 16, kSmallestLabel = 6;  // px
constexpr double kLabelShare = 0.35;                      // of the place's smaller side
constexpr double kBarShare = 0.15;  // of the plan's width, about: the scale bar

// Light enough for dark lines; neighbours in the list differ in lightness too.
constexpr const char* kFills[] = {"#cfe3f5", "#f7d9c4", "#d9efd2", "#b9cbe0", "#f6efc0",
                                  "#e6d3ea", "#e3bfae", "#b8d8c4", "#f9e4ee", "#cbc3dd"};
constexpr const char* kWall = "#202428";
constexpr const char* kVoid = "#d4d4d4";
constexpr const char* kCell = "#8a98a8";
constexpr const char* kPortal = "#3fae62";
constexpr const char* kDoor = "#0a7f3f";
constexpr const char* kLamp = "#e0a800";

// The axis against which the lamps shine; z where they shine all ways.
Vec3 up_of(const Scene& scene) {
  Vec3 flow{0};
  double flux = 0;
  for (const Surface& s : scene.surfaces) {
    const Spectrum& exitance = scene.materials[s.material.value].exitance;
    const PolygonView polygon = scene.polygon(s);
    const double lumens = (exitance.x + exitance.y + exitance.z) * area(polygon);
    if (s.sides != kFront) continue;
    flux += lumens;
    flow += lumens * plane_of(polygon).normal;
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(flow[k]) > std::abs(flow[axis])) axis = k;
  if (std::abs(flow[axis]) <= kOneWay * flux) return {0, 0, 1};
  Vec3 up{0};
  up[axis] = flow[axis] > 0 ? -1 : 1;
  return up;
}

// Heights of the storeys' floors along `up`, the lowest first: on each the level with most floor.
std::vector<double> storeys_of(const Scene& scene, const Vec3& up) {
  std::map<long, double> area_at;
  for (const Surface& s : scene.surfaces) {
    const PolygonView polygon = scene.polygon(s);
    const Vec3 a = area_vector(polygon);
    const double facing = dot(a, up) / length(a);
    if ((s.sides & kFront && facing > kLevel) || (s.sides & kBack && facing < -kLevel))
      area_at[std::lround(dot(polygon[0], up) / kSameLevel)] += 0.5 * length(a);
  }
  double most = 0;
  for (const auto& [level, a] : area_at) most = std::max(most, a);
  std::vector<double> storeys;
  double best = 0, base = 0;
  for (const auto& [level, a] : area_at) {
    if (a < kStoreyShare * most) continue;
    const double height = double(level) * kSameLevel;
    if (storeys.empty() || height > base + kStoreyHeight) {
      storeys.push_back(height);
      base = height, best = a;
    } else if (a > best) {
      storeys.back() = height;
      best = a;
    }
  }
  return storeys;
}

// Where a level plane cuts things, and how its points lie on paper.
class Section {
 public:
  Section(const Box& bounds, const Vec3& up, double height) : plane_{up, height} {
    across_ = std::abs(up.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    along_ = cross(up, across_);
    const Vec3 half = 0.5 * bounds.extent();
    half_ = {std::abs(dot(half, across_)), std::abs(dot(half, along_))};
    center_ = {dot(bounds.center(), across_), dot(bounds.center(), along_)};
    scale_ = 0.5 * std::min(kWidth / half_.x, kHeight / half_.y);
  }

  double scale() const { return scale_; }  // px a metre
  double width() const { return std::max(kLeastWidth, 2 * half_.x * scale_ + 2 * kMargin); }
  double height() const { return 2 * half_.y * scale_ + kHead + kFoot + 2 * kMargin; }

  Vec2 on_paper(const Vec3& x) const {
    return {(dot(x, across_) - center_.x + half_.x) * scale_ + kMargin,
            (half_.y + center_.y - dot(x, along_)) * scale_ + kHead + kMargin};
  }

  // Where the plane cuts a polygon: one segment of it.
  std::optional<std::array<Vec2, 2>> cut(PolygonView polygon) const {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      const double da = plane_.distance(a), db = plane_.distance(b);
      if ((da > 0) != (db > 0)) points.push_back(a + da / (da - db) * (b - a));
    }
    if (points.size() != 2) return std::nullopt;
    return std::array{on_paper(points[0]), on_paper(points[1])};
  }

  // The convex polygon in which it cuts a cell.
  std::vector<Vec2> cut(const ConvexCell& cell) const {
    std::vector<Vec2> points;
    for (const CellFace& face : cell.faces)
      if (const auto segment = cut(face.polygon))
        points.insert(points.end(), segment->begin(), segment->end());
    Vec2 middle{0};
    for (const Vec2& p : points) middle += p / double(points.size());
    std::sort(points.begin(), points.end(), [&](const Vec2& a, const Vec2& b) {
      return std::atan2(a.y - middle.y, a.x - middle.x) <
             std::atan2(b.y - middle.y, b.x - middle.x);
    });
    return points;
  }

 private:
  Plane plane_;
  Vec3 across_, along_;
  Vec2 half_, center_;  // m
  double scale_ = 1;
};

double area_of(const std::vector<Vec2>& points) {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2 &a = points[i], &b = points[(i + 1) % points.size()];
    sum += a.x * b.y - a.y * b.x;
  }
  return std::abs(sum) / 2;
}

const char* fill_of(std::uint32_t space) {
  if (space == kOutdoors) return "none";
  return space == kNoSpace ? kVoid : kFills[space % std::size(kFills)];
}

// Where a room's number stands: in the middle of the largest cell that the section has of it.
struct Label {
  double whole = 0, largest = 0;  // px²
  Vec2 middle{0}, size{0};
};

class Drawing {
 public:
  Drawing(const Scene& scene, const RoomPlan& plan, const Section& section)
      : scene_(scene), plan_(plan), section_(section) {
    svg_ << std::fixed << std::setprecision(1);
  }

  void begin(const std::string& title) {
    svg_
        << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << section_.width()
        << "\" height=\"" << section_.height()
        << "\" font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        << "<text x=\"" << kMargin << "\" y=\"" << kMargin + 14 << "\" font-size=\"15\">" << title
        << "</text>\n";
  }

  void cells() {
    svg_ << "<g stroke=\"" << kCell << "\" stroke-width=\"0.4\">\n";
    for (std::size_t c = 0; c < plan_.bsp.cells.size(); ++c) {
      const std::vector<Vec2> outline = section_.cut(plan_.bsp.cells[c]);
      const std::uint32_t space = plan_.space_of_cell[c];
      if (outline.size() < 3 || space == kOutdoors) continue;
      svg_ << "<polygon fill=\"" << fill_of(space) << "\" points=\"" << svg_points(outline)
           << "\"/>\n";
      if (space != kNoSpace) note(outline, labels_[space]);
    }
    svg_ << "</g>\n";
  }

  // Those that join different spaces are drawn over those that merely run on through a room.
  void portals() {
    for (const bool door : {false, true}) {
      svg_ << "<g stroke=\"" << (door ? kDoor : kPortal) << "\" stroke-width=\"" << (door ? 3 : 0.8)
           << "\">\n";
      for (const CellPortal& p : plan_.portals) {
        const std::uint32_t a = plan_.space_of_cell[p.front], b = plan_.space_of_cell[p.back];
        if ((a == kOutdoors || a == kNoSpace) && (b == kOutdoors || b == kNoSpace)) continue;
        if ((a != b) == door) line(p.polygon);
      }
      svg_ << "</g>\n";
    }
  }

  void surfaces() {
    svg_ << "<g stroke=\"" << kWall << "\" stroke-width=\"1.1\" stroke-linecap=\"round\">\n";
    for (const Surface& s : scene_.surfaces) line(scene_.polygon(s));
    svg_ << "</g>\n";
  }

  // Those of the storey: between `floor` and `ceiling` along up.
  void lamps(const Vec3& up, double floor, double ceiling) {
    svg_ << "<g stroke=\"" << kLamp << "\" stroke-width=\"0.7\" fill=\"none\">\n";
    for (const Surface& s : scene_.surfaces) {
      if (!scene_.materials[s.material.value].emits()) continue;
      const PolygonView polygon = scene_.polygon(s);
      const double height = dot(centroid(polygon), up);
      if (height < floor || height > ceiling) continue;
      std::vector<Vec2> outline;
      for (const Vec3& x : polygon) outline.push_back(section_.on_paper(x));
      svg_ << "<polygon points=\"" << svg_points(outline) << "\"/>\n";
    }
    svg_ << "</g>\n";
  }

  void labels() {
    svg_ << "<g text-anchor=\"middle\" dominant-baseline=\"central\" fill=\"" << kWall
         << "\" stroke=\"white\" stroke-width=\"2.5\" paint-order=\"stroke\">\n";
    const double px2 = section_.scale() * section_.scale();
    for (const auto& [space, label] : labels_) {
      if (label.whole < kLabelArea * px2) continue;
      const double size = std::clamp(kLabelShare * std::min(label.size.x, label.size.y),
                                     kSmallestLabel, kLargestLabel);
      svg_ << "<text x=\"" << label.middle.x << "\" y=\"" << label.middle.y << "\" font-size=\""
           << size << "\">" << space << "</text>\n";
    }
    svg_ << "</g>\n";
  }

  std::string end() {
    const double y = section_.height() - kFoot + 20;
    scale_bar(y);
    legend(y);
    svg_ << "</svg>\n";
    return svg_.str();
  }

 private:
  void line(PolygonView polygon) {
    const auto cut = section_.cut(polygon);
    if (!cut) return;
    const auto& [a, b] = *cut;
    svg_ << "<line x1=\"" << a.x << "\" y1=\"" << a.y << "\" x2=\"" << b.x << "\" y2=\"" << b.y
         << "\"/>\n";
  }

  static void note(const std::vector<Vec2>& outline, Label& label) {
    const double area = area_of(outline);
    label.whole += area;
    if (area <= label.largest) return;
    label.largest = area;
    Vec2 lo = outline[0], hi = outline[0];
    label.middle = {0, 0};
    for (const Vec2& p : outline) {
      lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
      hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
      label.middle += p / double(outline.size());
    }
    label.size = hi - lo;
  }

  // A round number of metres.
  void scale_bar(double y) {
    const double about = kBarShare * (section_.width() - 2 * kMargin) / section_.scale();
    const double metres = round_step(about);
    const double end = kMargin + metres * section_.scale();
    std::ostringstream text;
    text << metres << " m";
    svg_ << "<g stroke=\"" << kWall << "\" stroke-width=\"1.5\"><path fill=\"none\" d=\"M"
         << kMargin << ' ' << y - 5 << "V" << y << "H" << end << "V" << y - 5
         << "\"/></g>\n<text x=\"" << kMargin << "\" y=\"" << y + 18 << "\" font-size=\"13\">"
         << text.str() << "</text>\n";
  }

  void legend(double y) {
    constexpr double kStart = 0.25, kStep = 130, kSwatch = 20;
    const std::pair<const char*, const char*> entries[] = {{kWall, "surfaces"},
                                                           {kDoor, "room's end"},
                                                           {kPortal, "portal"},
                                                           {kLamp, "lamp"},
                                                           {kVoid, "no room"}};
    double x = kStart * section_.width();
    for (const auto& [colour, name] : entries) {
      svg_ << "<line x1=\"" << x << "\" y1=\"" << y << "\" x2=\"" << x + kSwatch << "\" y2=\"" << y
           << "\" stroke=\"" << colour << "\" stroke-width=\"4\"/><text x=\"" << x + kSwatch + 6
           << "\" y=\"" << y + 5 << "\" font-size=\"13\">" << name << "</text>\n";
      x += kStep;
    }
  }

  const Scene& scene_;
  const RoomPlan& plan_;
  const Section& section_;
  std::ostringstream svg_;
  std::map<std::uint32_t, Label> labels_;
};

std::string title_of(const RoomPlan& plan, const FloorPlanOptions& options, std::size_t storeys) {
  std::ostringstream text;
  text << "storey " << options.storey << " of " << storeys << ", " << options.height
       << " m above its floor; in all " << plan.rooms << " rooms, " << plan.bsp.cells.size()
       << " cells, " << plan.portals.size() << " portals";
  return text.str();
}

}  // namespace

Result<std::string> floor_plan_svg(const Scene& scene, const RoomPlan& plan,
                                   const FloorPlanOptions& options) {
  const Vec3 up = up_of(scene);
  std::vector<double> storeys = storeys_of(scene, up);
  const double bottom = std::min(dot(scene.bounds.lo, up), dot(scene.bounds.hi, up));
  if (storeys.empty()) storeys.push_back(bottom);
  if (options.storey > storeys.size())
    return Status(Code::kUsage, "", "", "there is no storey " + std::to_string(options.storey),
                  "the scene has " + std::to_string(storeys.size()));
  const double floor = storeys[options.storey - 1];
  const double ceiling = options.storey < storeys.size()
                             ? storeys[options.storey]
                             : std::max(dot(scene.bounds.lo, up), dot(scene.bounds.hi, up));
  const Section section(scene.bounds, up, floor + options.height);
  Drawing drawing(scene, plan, section);
  drawing.begin(title_of(plan, options, storeys.size()));
  drawing.cells();
  drawing.portals();
  drawing.surfaces();
  drawing.lamps(up, floor, ceiling);
  drawing.labels();
  return drawing.end();
}

}  // namespace atrium
