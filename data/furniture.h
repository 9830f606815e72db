// Office furniture in two grades of detail: coarse (boxes) and fine (rounded legs, keys, castors).
//
// A piece is one group in a local frame: x to the right, y away from its user, z up from the floor.
// Pieces lack the faces they stand on; nothing lies in another face's plane.
#pragma once

#include <string>
#include <vector>

#include "data/dice.h"
#include "data/plan.h"

namespace atrium::generator {

enum class Furnish { kNone, kLow, kHigh };

struct FurniturePaints {
  PaintId wood, pale, dark, metal, cloth, screen, leaf, soil, lamp;
  std::vector<PaintId> books;
};
FurniturePaints furniture_paints(ModelBuilder& out, PaintId lamp);

// Where the next pieces go: a builder, their paints and grade, and the room's name.
struct Furnisher {
  ModelBuilder& out;
  const FurniturePaints& paints;
  Furnish grade = Furnish::kLow;
  std::string room;
  bool fine() const { return grade == Furnish::kHigh; }
  void begin(const std::string& piece, int number);
};

// Nine pieces about a desk of 1.6 × 0.8 m whose far edge's middle is the origin: desk, pedestal,
// chair, monitor, keyboard, computer, lamp, telephone, bin. One light.
void workstation(Furnisher& f, int number, const Placement& at, Dice& dice);
inline constexpr Rect kWorkstation{-1150, 850, -1600, 0};  // mm, its footprint
inline constexpr int kWorkstationPieces = 9;

// A bookcase of 0.9 × 0.3 m (far edge's middle at the origin), and books in it of so many faces in
// all, as far as they fit: five a book, the last one more. Two pieces; returns the books' faces.
int bookcase(Furnisher& f, int number, const Placement& at, int book_faces, Dice& dice);
inline constexpr Rect kBookcase{-460, 460, -300, 0};  // mm, with a gap on either side
int usual_book_faces(Furnish grade);

// In a pot about the origin.
void plant(Furnisher& f, int number, const Placement& at, Dice& dice);

inline constexpr Rect kPlant{-250, 250, -250, 250};  // mm

// A table of 1.4 × 0.5 m with two chairs: three pieces.
void school_table(Furnisher& f, int number, const Placement& at);
inline constexpr Rect kSchoolTable{-700, 700, -1000, 0};  // mm

}  // namespace atrium::generator
