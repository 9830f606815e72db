#include "visibility/gap_words.h"

#include <iomanip>
#include <sstream>

#include "engine/quantity.h"

namespace atrium {

namespace {

constexpr std::size_t kNamed = 4;  // objects of one gap
constexpr int kPlaceDigits = 5;

}  // namespace

std::vector<NamedGap> named_gaps(const Scene& scene, const std::vector<ClosedGap>& gaps) {
  std::vector<NamedGap> out;
  for (const ClosedGap& gap : gaps)
    out.push_back(
        {gap.width, gap.length, scene.frame.to_file(gap.at), names_of(scene, gap.objects)});
  return out;
}

std::string gap_words(const NamedGap& gap) {
  return format_length(gap.width) + " x " + format_length(gap.length) + " at " +
         short_place(gap.at) + ": " + objects_words(gap.objects);
}

std::vector<std::string> names_of(const Scene& scene, const std::vector<ObjectId>& objects) {
  std::vector<std::string> names;
  for (const ObjectId object : objects) names.push_back(scene.objects[object.value].name);
  return names;
}

std::string objects_words(const std::vector<std::string>& objects) {
  std::string text;
  for (std::size_t i = 0; i < objects.size() && i < kNamed; ++i)
    text += (i > 0 ? ", " : "") + objects[i];
  if (objects.size() > kNamed) text += " and " + std::to_string(objects.size() - kNamed) + " more";
  return text;
}

std::string short_place(const Vec3& x) {
  std::ostringstream text;
  text << std::setprecision(kPlaceDigits) << x.x << ' ' << x.y << ' ' << x.z;
  return text.str();
}

}  // namespace atrium
