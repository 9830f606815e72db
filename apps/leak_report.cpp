#include "apps/leak_report.h"

#include <iomanip>
#include <sstream>

#include "engine/quantity.h"
#include "visibility/gap_words.h"

namespace atrium {
namespace {

constexpr int kSize = 11, kRooms = 20, kPlace = 30;  // columns

std::string room_name(std::uint32_t space) {
  return space == kOutdoors ? "outdoors" : std::to_string(space);
}

// A CSV field: quoted, its quotes doubled.
std::string csv_field(const std::string& text) {
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}

}  // namespace

std::vector<LeakRow> leak_rows(const Scene& scene, const std::vector<Leak>& leaks) {
  std::vector<LeakRow> rows;
  for (const Leak& leak : leaks) {
    LeakRow row{leak.width,
                leak.length,
                {room_name(leak.spaces[0]), room_name(leak.spaces[1])},
                names_of(scene, leak.objects),
                scene.frame.to_file(leak.at),
                leak.along};
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string leak_table(const std::vector<LeakRow>& leaks, std::uint32_t rooms, double size) {
  std::ostringstream text;
  text << rooms << " rooms; openings below " << format_length(size)
       << " that join two of them or lead outdoors: " << leaks.size() << '\n';
  if (leaks.empty()) return text.str();
  text << std::left << '\n'
       << std::setw(kSize) << "width" << std::setw(kSize) << "length" << std::setw(kRooms)
       << "rooms" << std::setw(kPlace) << "at"
       << "objects around it\n";
  for (const LeakRow& leak : leaks)
    text << std::setw(kSize) << format_length(leak.width) << std::setw(kSize)
         << format_length(leak.length) << std::setw(kRooms) << leak.rooms[0] + ", " + leak.rooms[1]
         << std::setw(kPlace) << short_place(leak.at) << objects_words(leak.objects) << '\n';
  return text.str();
}

std::string leak_csv(const std::vector<LeakRow>& leaks) {
  std::ostringstream rows;
  rows << std::setprecision(17) << "width,length,room_a,room_b,x,y,z,along_x,along_y,along_z,"
       << "objects\n";
  for (const LeakRow& leak : leaks) {
    std::string objects;
    for (const std::string& name : leak.objects) objects += (objects.empty() ? "" : "; ") + name;
    rows << leak.width << ',' << leak.length << ',' << leak.rooms[0] << ',' << leak.rooms[1];
    for (const Vec3& v : {leak.at, leak.along}) rows << ',' << v.x << ',' << v.y << ',' << v.z;
    rows << ',' << csv_field(objects) << '\n';
  }
  return rows.str();
}

}  // namespace atrium
