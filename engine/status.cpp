#include "engine/status.h"

namespace atrium {

std::string Status::message() const {
  std::string text = file_;
  if (!place_.empty()) text += (text.empty() ? "" : ": ") + place_;
  if (!cause_.empty()) text += (text.empty() ? "" : ": ") + cause_;
  if (!remedy_.empty()) text += "; " + remedy_;
  return text;
}

}  // namespace atrium
