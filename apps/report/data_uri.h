// Bytes as an address of themselves, so that a page holds its pictures. [RFC 2397, RFC 4648 §4]
#pragma once

#include <string>
#include <string_view>

namespace atrium {

// type: "image/png"
std::string data_uri(std::string_view type, std::string_view bytes);

}  // namespace atrium
